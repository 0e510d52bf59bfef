#!/usr/bin/env node
/* gltf-command.js - conquest-gltf IN.glb OUT.glb [BITS]: makes the meshes of a glTF file progressive; from a progressive one
 * with --plain as the third word, plain ones again. SPDX-License-Identifier: MIT */
import { openCodec } from "./conquest.js";

const [from, to, how = "14"] = process.argv.slice(2);
const LIBRARIES = ["@gltf-transform/core", "@gltf-transform/extensions"];

/** Files that are compressed already: the package that reads them, and what of it. */
const DECODERS = {
    KHR_draco_mesh_compression: {
        name: "draco3d",
        key: "draco3d.decoder",
        open: draco => draco.default.createDecoderModule(),
    },
    EXT_meshopt_compression: {
        name: "meshoptimizer",
        key: "meshopt.decoder",
        open: ({ MeshoptDecoder }) => MeshoptDecoder.ready.then(() => MeshoptDecoder),
    },
};

/** A package that the user has, or not. @param {string} name @param {string[]} all  to be installed */
async function load(name, all = [name]) {
    try {
        return await import(name);
    } catch (error) {
        if (error.code !== "ERR_MODULE_NOT_FOUND") throw error;
        throw new Error(`${name} is missing: npm install ${all.join(" ")}`);
    }
}

/** @param {import("@gltf-transform/core").NodeIO} io */
async function readJSON(io) {
    try {
        return await io.readAsJSON(from);
    } catch (error) {
        throw error.code ? error : new Error(`${from} is no glTF 2.0 file: ${error.message}`);
    }
}

/** The file, without compression. @param {import("@gltf-transform/core").NodeIO} io */
async function read(io) {
    const source = await readJSON(io),
        used = Object.keys(DECODERS).filter(extension => source.json.extensionsUsed?.includes(extension));
    for (const { name, key, open } of used.map(extension => DECODERS[extension]))
        io.registerDependencies({ [key]: await open(await load(name)) });
    const document = await io.readJSON(source);
    drop(document, used);
    return document;
}

/** Extensions that are not to be written. @param {import("@gltf-transform/core").Document} document
 *  @param {string[]} names */
function drop(document, names) {
    for (const extension of document.getRoot().listExtensionsUsed())
        if (names.includes(extension.extensionName)) extension.dispose();
}

async function run() {
    const bits = Number(how);
    if (how !== "--plain" && !(Number.isInteger(bits) && ((bits >= 1 && bits <= 24) || bits === 32)))
        throw new Error(`BITS have to be 1 .. 24 or 32, not ${how}`);
    const [{ NodeIO }, { ALL_EXTENSIONS }] = [await load(LIBRARIES[0], LIBRARIES), await load(LIBRARIES[1], LIBRARIES)];
    const { ConquestMeshProgressive, NAME, progressive } = await import("./gltf-transform.js"),
        io = new NodeIO()
            .registerExtensions([...ALL_EXTENSIONS, ConquestMeshProgressive])
            .registerDependencies({ conquest: await openCodec() }),
        document = await read(io);
    if (how === "--plain") drop(document, [NAME]);
    else await document.transform(progressive({ bits }));
    await io.write(to, document);
}

if (!from || !to) {
    console.error("conquest-gltf IN.glb OUT.glb [BITS of positions, 32: exact | --plain]");
    process.exit(2);
}
run().catch(error => {
    console.error(`conquest-gltf: ${error.message}`);
    process.exitCode = 1;
});
