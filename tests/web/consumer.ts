/* What a program in TypeScript may write, and what it may not: checked by tsc against the installed package.
 * SPDX-License-Identifier: MIT */
import { Mesh, MeshStandardMaterial, Scene } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { Decoder, type Encoded, MeshError, type NodeWorker, type State, StreamError, decode, decodeAll, encode } from "conquest-mesh";
import { CQMLoader, errorInPixels } from "conquest-mesh/three";
import { ConquestGLTFPlugin, loadProgressive } from "conquest-mesh/three-gltf";
import { ConquestMeshProgressive, progressive } from "conquest-mesh/gltf-transform";

export async function use(bytes: ArrayBuffer, thread: NodeWorker): Promise<number> {
    for await (const state of decode(bytes, { budget: 4, memory: new WebAssembly.Memory({ initial: 1 }) })) {
        const first: number = state.attributes.positions.array[0] + state.index[0] + state.ranges[0].start;
        console.log(first, state.error.toFixed(2));
    }
    const last: State = await decodeAll(fetch("a.cqm"), { partial: true, worker: true });
    await decodeAll(bytes, { worker: thread });
    const encoded: Encoded = await encode({ index: [0, 1, 2], positions: new Float32Array(9) }, { bits: { positions: 14 } });
    const decoder = await Decoder.create();
    await decoder.feed(encoded.data);
    // @ts-expect-error: text is no piece of a stream
    await decoder.feed("text");
    // @ts-expect-error: there is no such option
    await decodeAll(bytes, { partially: true });
    // @ts-expect-error: nor such a goal
    await encode({ index: [0, 1, 2] }, { goal: "small" });
    return last.numFaces;
}

export async function draw(scene: Scene): Promise<void> {
    const loader = new CQMLoader().setWorkerLimit(2).stopAt({ vertices: 1000 });
    loader.onRefine = (geometry, state) => console.log(geometry.drawRange.count, state.level, errorInPixels(1, geometry, {}));
    const geometry = await loader.loadAsync("bunny.cqm");
    scene.add(new Mesh(geometry, new MeshStandardMaterial()));
    await geometry.loaded;
    // @ts-expect-error: a goal is an object
    loader.stopAt(1000);
}

export async function drawScene(scene: Scene): Promise<void> {
    const gltf = await loadProgressive("a.glb", new GLTFLoader(), { onRefine: (_, state) => state.error > 0.01 });
    scene.add(gltf.scene);
    await gltf.userData.loaded;
    new GLTFLoader().register(parser => new ConquestGLTFPlugin(parser));
    // @ts-expect-error: there is no such part of a file
    console.log(gltf.meshes);
    // @ts-expect-error: a path is no loader
    await loadProgressive("a.glb", "loader.js");
}

export const failed = (e: unknown) => e instanceof StreamError ? e.byte : e instanceof MeshError ? e.face : undefined;
export const rest = [ConquestMeshProgressive, progressive];
