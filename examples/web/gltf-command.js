#!/usr/bin/env node
/* gltf-command.js - conquest-gltf IN.glb OUT.glb [BITS]: makes the meshes of a glTF file progressive; from a
 * progressive one
 * with --plain as the third word, plain ones again. SPDX-License-Identifier: MIT */
import { NodeIO } from "@gltf-transform/core";
import { ALL_EXTENSIONS } from "@gltf-transform/extensions";
import { openCodec } from "./conquest.js";
import { ConquestMeshProgressive, NAME, progressive } from "./gltf-transform.js";

const [from, to, how = "14"] = process.argv.slice(2);
if (!from || !to || !(how === "--plain" || Number(how) > 0)) {
    console.error("conquest-gltf IN.glb OUT.glb [BITS of positions, 32: exact | --plain]");
    process.exit(2);
}
const io = new NodeIO()
    .registerExtensions([...ALL_EXTENSIONS, ConquestMeshProgressive])
    .registerDependencies({ conquest: await openCodec() });
const document = await io.read(from);
if (how === "--plain")
    document
        .getRoot()
        .listExtensionsUsed()
        .filter(e => e.extensionName === NAME)
        .forEach(e => e.dispose());
else await document.transform(progressive({ bits: Number(how) }));
await io.write(to, document);
