/* The package in a browser, and the loader for three.js. SPDX-License-Identifier: MIT */
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { after, test } from "node:test";
import { NodeIO } from "@gltf-transform/core";
import { chromium } from "playwright-core";
import { encode, openCodec } from "conquest-mesh";
import { ConquestMeshProgressive, NAME, progressive } from "conquest-mesh/gltf-transform";
import { addStreams, changeGlb, makeDocument, moveToFront } from "./documents.js";
import { serveFolder } from "./serve.js";
import { makeDressed, makeSphere } from "./meshes.js";

const mesh = makeSphere(96, 48),
    { data } = await encode(mesh, { bits: 14 });
const dressed = makeDressed(),
    { data: dressedData } = await encode(dressed, { bits: 14 });
const vertices = mesh.positions.length / 3,
    faces = mesh.index.length / 3;
const damaged = data.slice();
damaged[data.length >> 1] ^= 16;

// The same document, plain and progressive; how much of it comes before its first stream.
const io = new NodeIO()
    .registerExtensions([ConquestMeshProgressive])
    .registerDependencies({ conquest: await openCodec() });
const document = makeDocument(),
    plainGlb = await io.writeBinary(document);
await document.transform(progressive());
const glb = await io.writeBinary(document),
    { json } = await io.binaryToJSON(glb);
const listStreams = ({ meshes }) => [
    ...new Set(meshes.flatMap(m => m.primitives.flatMap(p => p.extensions?.[NAME]?.bufferView ?? []))),
];
const streams = listStreams(json);
const beforeStreams = glb.length - streams.reduce((sum, v) => sum + json.bufferViews[v].byteLength, 0);

// Its streams with what comes of them as a fallback, which is interleaved.
const decoded = await io.readBinary(glb);
decoded
    .getRoot()
    .listExtensionsUsed()
    .forEach(extension => extension.dispose());
const fallback = addStreams(await io.writeBinary(decoded), { json, glb }, NAME),
    fallbackJson = (await io.binaryToJSON(fallback)).json;

/** The file with something wrong in an extension of it. */
const spoil = change => changeGlb(glb, ({ meshes }) => change(meshes[1].primitives[0].extensions[NAME]));

// A larger one whose streams come first, by ranges: of streams only so much of each until a test says so.
const fine = makeDocument(5),
    plainFine = await io.writeBinary(fine);
await fine.transform(progressive());
const fineGlb = await io.writeBinary(fine),
    fineJson = (await io.binaryToJSON(fineGlb)).json,
    fineStreams = listStreams(fineJson),
    ranged = moveToFront(fineGlb, fineStreams);
const ranges = { asked: [], held: null, tag: "a" };

async function sendRange(request, response) {
    const [, from, last] = /^bytes=(\d+)-(\d+)$/.exec(request.headers.range).map(Number),
        end = Math.min(last + 1, ranged.length);
    ranges.asked.push([from, end]);
    if (end - from > 1024 && from > 0 && end < ranged.length) await ranges.held;
    response.writeHead(206, {
        "content-range": `bytes ${from}-${end - 1}/${ranged.length}`,
        "content-length": end - from,
        etag: ranges.tag,
        "cache-control": "no-store", // a browser keeps parts
    });
    response.end(ranged.subarray(from, end));
}

const waiting = [];
const send = bytes => (_, response) => response.writeHead(200, { "content-length": bytes.length }).end(bytes);
const server = await serveFolder("..", 0, {
    "/whole.cqm": send(data),
    "/test/bunny.cqm": send(data),
    "/dressed.cqm": send(dressedData),
    "/damaged.cqm": send(damaged),
    "/none.cqm": send(Buffer.from("solid of no mesh")),
    "/plain.glb": send(plainGlb),
    "/progressive.glb": send(glb),
    "/fallback.glb": send(fallback),
    "/group.glb": send(spoil(e => (e.group = 2))),
    "/channel.glb": send(spoil(e => (e.attributes.POSITION = 5))),
    "/attribute.glb": send(spoil(e => (e.attributes.NORMAL = 0))),
    "/plain-fine.glb": send(plainFine),
    "/ranged.glb": sendRange,
    "/slow.glb": (_, response) => {
        response.writeHead(200, { "content-length": glb.length });
        response.write(glb.subarray(0, beforeStreams + 700));
        waiting.push(response);
    },
    "/slow.cqm": (_, response) => {
        // its first kilobyte; the rest when a test says so
        response.writeHead(200, { "content-length": data.length });
        response.write(data.subarray(0, 1024));
        waiting.push(response);
    },
});
const browser = await chromium.launch({
    executablePath: "/usr/bin/chromium",
    args: [
        "--no-sandbox",
        "--use-gl=angle",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        "--js-flags=--expose-gc",
    ],
});
after(async () => {
    await browser.close();
    server.close();
    server.closeAllConnections();
});

const problems = [];
async function open() {
    const page = await browser.newPage();
    page.on("pageerror", error => problems.push(String(error)));
    await page.goto(`http://127.0.0.1:${server.address().port}/test/browser.html`);
    await page.waitForFunction("window.ready");
    return page;
}
const page = await open();
const plainMesh = { index: Array.from(mesh.index), positions: Array.from(mesh.positions) };

for (const workers of [0, 1]) {
    test(`draws while it arrives, ${workers} workers`, async () => {
        const before = await page.evaluate(async workers => {
            window.refined = 0;
            window.loader = new CQMLoader().setWorkerLimit(workers);
            loader.onRefine = () => {
                refined++;
            };
            window.geometry = await loader.loadAsync("/slow.cqm");
            const start = geometry.state.numVertices;
            await until(() => geometry.state.bytes === 1024);
            Object.assign(uploads, { allocated: 0, written: 0, calls: 0 });
            window.first = draw(geometry);
            return {
                ...uploads,
                start,
                vertices: geometry.state.numVertices,
                bytes: geometry.state.bytes,
                count: geometry.drawRange.count,
            };
        }, workers);
        assert.ok(
            before.start > 3 &&
                before.vertices > 20 &&
                before.vertices < vertices / 2 &&
                before.bytes <= 1024,
            JSON.stringify(before),
        );
        assert.equal(before.allocated, 12 * vertices + 12 * faces);
        waiting.pop().end(data.subarray(1024));
        const late = await page.evaluate(async plainMesh => {
            await geometry.loaded;
            const last = draw(geometry),
                exact = draw(plain(plainMesh)),
                { index, state } = geometry;
            loader.dispose();
            return {
                ...uploads,
                refined,
                first: compare(first, exact),
                last: compare(last, exact),
                faces: state.numFaces,
                count: geometry.drawRange.count,
                radius: geometry.boundingSphere.radius,
                largest: Math.max(...index.array),
            };
        }, plainMesh);
        assert.deepEqual([late.faces, late.count, late.largest], [faces, 3 * faces, vertices - 1]);
        assert.ok(late.refined > 1 && late.radius > 1 && late.radius < 2, JSON.stringify(late));
        assert.ok(late.last.shown > 5000 && late.last.different < 0.01, JSON.stringify(late.last));
        assert.ok(
            late.first.different > late.last.different && late.first.different < 0.9,
            JSON.stringify(late.first),
        );
        assert.ok(
            late.written >= 12 * (vertices - before.vertices) && late.written <= 12 * vertices + 12 * faces,
            JSON.stringify(late),
        );
        console.log(
            `${workers} workers: ${before.vertices} vertices of ${before.bytes} bytes, ${(100 * late.first.different).toFixed(1)} % of pixels differ`,
        );
    });
}

test("README's lines run", async () => {
    const readme = readFileSync("../../../README.md", "utf8"),
        [, door] = /<!-- door: web -->\n+```js\n(.*?)```/s.exec(readme);
    const own = await open();
    await own.evaluate(() => {
        const drawn = [];
        Object.assign(window, {
            drawn,
            scene: new THREE.Scene(),
            material: new THREE.MeshStandardMaterial(),
            draw: (index, positions, ranges) => drawn.push([index.length, positions.length, ranges.length]),
        });
    });
    await own.addScriptTag({ type: "module", content: `${door}\nwindow.geometry = geometry;` });
    await own.waitForFunction("window.geometry");
    const got = await own.evaluate(() => ({
        inScene: scene.children.map(child => child.geometry === geometry),
        range: geometry.drawRange.count,
        drawn,
    }));
    await own.close();
    assert.deepEqual([got.inScene, got.range], [[true], 3 * faces]);
    assert.ok(got.drawn.length > 1);
    assert.ok(got.drawn.every(([index, positions, ranges]) => index === 3 * faces && positions === 3 * vertices && ranges));
});

/** Lines of a document that use the loader, without what they import. */
function takeExample(path) {
    const blocks = [...readFileSync(path, "utf8").matchAll(/```js\n([^]*?)```/g)].map(m => m[1]),
        found = blocks.filter(code => code.includes("new CQMLoader()"));
    assert.equal(found.length, 1, path);
    return found[0].replace(/^import .*\n/gm, "");
}

test("the lines of the package's README load a file in three.js", async () => {
    const example = takeExample(join("..", "..", "..", "examples", "web", "README.md"));
    const got = await page.evaluate(async example => {
        const { Mesh, MeshStandardMaterial, Scene } = THREE,
            scene = new Scene(),
            Run = (async () => {}).constructor;
        await new Run("CQMLoader", "Mesh", "MeshStandardMaterial", "scene", example)(
            CQMLoader,
            Mesh,
            MeshStandardMaterial,
            scene,
        );
        const [{ geometry }] = scene.children;
        return { complete: geometry.state.complete, faces: geometry.state.numFaces, shown: compare(drawScene(scene), new Uint8Array(160000)).shown };
    }, example);
    assert.deepEqual([got.complete, got.faces], [true, faces]);
    assert.ok(got.shown > 500, JSON.stringify(got));
});

test("all attributes come to the GPU; a draw call for each material", async () => {
    const got = await page.evaluate(async () => {
        const geometry = await new CQMLoader().loadAsync("/dressed.cqm");
        await geometry.loaded;
        const material = () => new THREE.MeshStandardMaterial({ vertexColors: true });
        draw(geometry, [material(), material(), material()]);
        const calls = renderer.info.render.calls;
        const read = name => Array.from(geometry.getAttribute(name).array.slice(0, 12));
        return {
            names: Object.keys(geometry.attributes).sort(),
            groups: geometry.groups,
            skinIndex: read("skinIndex"),
            calls,
        };
    });
    assert.deepEqual(got.names, ["color", "normal", "position", "skinIndex", "skinWeight", "tangent", "uv"]);
    assert.equal(got.calls, 3);
    assert.deepEqual(
        got.groups.map(g => g.materialIndex),
        [0, 1, 2],
    );
    assert.equal(
        got.groups.reduce((sum, g) => sum + g.count, 0),
        dressed.index.length,
    );
    assert.ok(got.skinIndex.every(j => Number.isInteger(j) && j < 8));
});

test("stops at a number of vertices, at an error, at pixels until the camera comes nearer", async () => {
    const got = await page.evaluate(async () => {
        const load = async goal => {
            const loader = new CQMLoader().setWorkerLimit(0).stopAt(goal),
                pieces = new ReadableStream({
                    async start(c) {
                        for (let at = 0; at < bytes.length; at += 200) c.enqueue(bytes.slice(at, at + 200));
                        c.close();
                    },
                });
            return loader.refine(pieces, () => {});
        };
        const bytes = new Uint8Array(await (await fetch("/whole.cqm")).arrayBuffer());
        const few = await (await load({ vertices: 300 })).loaded,
            near = await (await load({ error: 0.02 })).loaded;
        const far = camera.clone();
        far.position.multiplyScalar(20);
        far.updateMatrixWorld();
        const screen = await load({ pixels: 1, camera: far, height: 400 });
        const pixelsNow = () => errorInPixels(screen.state.error, screen, { camera: far, height: 400 });
        await until(() => screen.state && pixelsNow() <= 1);
        await new Promise(r => setTimeout(r, 500)); // it does not go on
        const paused = screen.state.numVertices,
            pixels = pixelsNow();
        far.position.multiplyScalar(1 / 20);
        far.updateMatrixWorld();
        await until(() => screen.state.numVertices > 2 * paused);
        return {
            few: few.state.numVertices,
            near: [near.state.error, near.state.numVertices],
            paused,
            pixels,
            then: screen.state.numVertices,
        };
    });
    assert.ok(got.few >= 300 && got.few < 600, JSON.stringify(got));
    assert.ok(got.near[0] <= 0.02 && got.near[1] < vertices, JSON.stringify(got));
    assert.ok(got.paused < vertices / 2 && got.pixels <= 1 && got.then > 2 * got.paused, JSON.stringify(got));
});

test("a cut connection, a corrupt file and one that is none are errors with words; the page lives", async () => {
    const load = url =>
        page.evaluate(async url => {
            const loader = new CQMLoader(),
                errors = [];
            const geometry = await loader.loadAsync(url).catch(error => {
                errors.push(String(error));
                return null;
            });
            window.started = url;
            await geometry?.loaded.catch(error => errors.push(String(error)));
            if (geometry) draw(geometry);
            return { errors, vertices: geometry?.state.numVertices };
        }, url);
    const damage = await load("/damaged.cqm");
    assert.match(damage.errors[0], /^StreamError: (corrupt stream|check value mismatch) \(byte \d+\)$/);
    assert.ok(damage.vertices === undefined || damage.vertices < vertices);
    assert.match((await load("/none.cqm")).errors[0], /^StreamError: not a conquest stream \(byte 16\)$/);
    assert.match((await load("/missing.cqm")).errors[0], /404/);
    const cut = load("/slow.cqm");
    await page.waitForFunction(() => window.started === "/slow.cqm");
    waiting.pop().destroy();
    const broken = await cut;
    assert.match(broken.errors[0], /network error/);
    assert.ok(broken.vertices > 20);
    assert.equal((await load("/whole.cqm")).vertices, vertices);
});

test("a geometry that is stopped waits for no more bytes; a worker that cannot start is an error", async () => {
    const got = await page.evaluate(async () => {
        const geometry = await new CQMLoader().loadAsync("/slow.cqm");
        geometry.stop();
        const stopped = await geometry.loaded;
        const worker = new Worker("/test/none.js", { type: "module" });
        const error = await conquest.decodeAll("/whole.cqm", { worker }).catch(e => e);
        return { vertices: stopped.state.numVertices, error: String(error) };
    });
    waiting.pop().destroy();
    assert.ok(got.vertices > 20 && got.vertices < vertices, JSON.stringify(got));
    assert.match(got.error, /^Error: the worker cannot start$/);
});

test("a goal that is none is an error", async () => {
    const errors = await page.evaluate(() =>
        [1000, undefined, {}, { vertex: 1000 }, { pixels: 1 }].map(goal => {
            try {
                return String(new CQMLoader().stopAt(goal));
            } catch (error) {
                return error.name;
            }
        }),
    );
    assert.deepEqual(errors, Array(5).fill("TypeError"));
});

test("what still loads when its loader is disposed rejects with an AbortError; the loader loads on", async () => {
    const got = await page.evaluate(async () => {
        const name = promise => promise.then(() => "loaded", error => error.name),
            errors = [];
        for (const workers of [0, 1]) {
            const loader = new CQMLoader().setWorkerLimit(workers),
                early = loader.loadAsync("/whole.cqm");
            loader.dispose();
            errors.push(await name(early));
            const geometry = await loader.loadAsync("/slow.cqm");
            loader.dispose();
            errors.push(await name(geometry.loaded));
            const far = await loader.loadAsync("/whole.cqm");
            errors.push(await name(far.loaded));
            loader.dispose();
        }
        return errors;
    });
    waiting.splice(0).forEach(response => response.destroy());
    const each = ["AbortError", "AbortError", "loaded"];
    assert.deepEqual(got, [...each, ...each]);
});

test("encodes in the browser, the same bytes", async () => {
    const bytes = await page.evaluate(
        async mesh =>
            Array.from(
                (
                    await conquest.encode(
                        { index: mesh.index, positions: Float32Array.from(mesh.positions) },
                        { bits: 14 },
                    )
                ).data,
            ),
        plainMesh,
    );
    assert.deepEqual(Buffer.from(bytes), Buffer.from(data));
});

test("a glTF file is drawn while it arrives, and whole", async () => {
    const early = await page.evaluate(async () => {
        window.gltf = await loadProgressive("/slow.glb", new GLTFLoader());
        const drawn = () => gltf.scene.getObjectByProperty("isMesh", true)?.geometry.drawRange.count > 30;
        await until(drawn);
        window.early = drawScene(gltf.scene);
        let faces = 0;
        gltf.scene.traverse(o => {
            if (o.isMesh) faces += o.geometry.drawRange.count / 3;
        });
        return {
            faces,
            names: gltf.scene.children.map(c => c.name),
            shown: compare(early, new Uint8Array(early.length)).shown,
        };
    });
    assert.ok(early.shown > 1000 && early.faces > 10, JSON.stringify(early));
    assert.ok(early.names.includes("body"), JSON.stringify(early));
    waiting.pop().end(glb.subarray(beforeStreams + 700));
    const late = await page.evaluate(async () => {
        await gltf.userData.loaded;
        const load = async (url, loader) => {
            const whole = await loader.loadAsync(url);
            await whole.userData.loaded;
            return drawScene(whole.scene);
        };
        const plain = await load("/plain.glb", new GLTFLoader());
        const again = await load(
            "/progressive.glb",
            new GLTFLoader().register(parser => new ConquestGLTFPlugin(parser)),
        );
        return {
            early: compare(early, plain),
            late: compare(drawScene(gltf.scene), plain),
            again: compare(again, plain),
        };
    });
    assert.ok(
        late.late.shown > 3000 && late.late.different < 0.01 && late.again.different < 0.01,
        JSON.stringify(late),
    );
    assert.ok(late.early.different > late.late.different, JSON.stringify(late));
});

test("a glTF file whose fallback is interleaved is drawn from its streams", async () => {
    const strides = fallbackJson.bufferViews.map(view => view.byteStride ?? 0);
    assert.ok(Math.max(...strides) > 16 && !fallbackJson.extensionsRequired, strides.join(" "));
    const got = await page.evaluate(async () => {
        const draw = async gltf => {
            await gltf.userData.loaded;
            return drawScene(gltf.scene);
        };
        const plugin = parser => new ConquestGLTFPlugin(parser),
            plain = await draw(await new GLTFLoader().loadAsync("/plain.glb")),
            ignored = await draw(await new GLTFLoader().loadAsync("/fallback.glb")),
            whole = await draw(await new GLTFLoader().register(plugin).loadAsync("/fallback.glb")),
            gltf = await loadProgressive("/fallback.glb", new GLTFLoader()),
            arrives = await draw(gltf);
        const used = new Set();
        gltf.scene.traverse(o => o.isMesh && Object.values(o.geometry.attributes).forEach(a => used.add(a)));
        return {
            pixels: [ignored, whole, arrives].map(picture => compare(picture, plain)),
            filled: [...used].every(a => a.array.some(x => x !== 0)),
        };
    });
    assert.ok(got.filled && got.pixels.every(p => p.shown > 3000 && p.different < 0.01), JSON.stringify(got));
});

test("a glTF file that asks for what its stream does not have is an error", async () => {
    const errors = await page.evaluate(() =>
        Promise.all(
            ["/group.glb", "/channel.glb", "/attribute.glb"].map(async url => {
                const { userData } = await loadProgressive(url, new GLTFLoader());
                return userData.loaded.then(() => "no error", String);
            }),
        ),
    );
    assert.deepEqual(errors, [
        "Error: CONQUEST_mesh_progressive: a primitive is group 2, of a stream that has 2",
        "Error: CONQUEST_mesh_progressive: POSITION is channel 5, of a stream that has 1",
        "Error: CONQUEST_mesh_progressive: NORMAL is no attribute of the primitive",
    ]);
});

test("a glTF file by ranges: some bytes of each mesh first, each byte once, no more of what is fine enough", async () => {
    let release;
    ranges.held = new Promise(resolve => {
        release = resolve;
    });
    const early = await page.evaluate(async () => {
        window.gltf = await loadProgressive("/ranged.glb", new GLTFLoader(), { ranges: true });
        const shown = () => {
            const seen = new Set();
            gltf.scene.traverse(o => o.isMesh && o.geometry.drawRange.count > 30 && seen.add(o.geometry));
            return seen.size;
        };
        await until(() => shown() === 3);
        return { shown: shown(), pixels: (window.early = drawScene(gltf.scene)).length };
    });
    const asked = ranges.asked.reduce((sum, [from, end]) => sum + end - from, 0);
    assert.equal(early.shown, 3);
    release();
    const late = await page.evaluate(async () => {
        await gltf.userData.loaded;
        const plain = drawScene((await new GLTFLoader().loadAsync("/plain-fine.glb")).scene);
        return { early: compare(early, plain), late: compare(drawScene(gltf.scene), plain) };
    });
    assert.ok(late.late.shown > 3000 && late.late.different < 0.02, JSON.stringify(late));
    assert.ok(late.early.different > late.late.different, JSON.stringify(late));
    const parts = ranges.asked.splice(0).sort((a, b) => a[0] - b[0]);
    parts.slice(1).forEach(([from], k) => assert.ok(from >= parts[k][1], `byte ${from} twice`));
    console.log(`${ranged.length} bytes in ${parts.length} parts; ${asked} asked for before all meshes were seen`);

    const stopped = await page.evaluate(async () => {
        const onRefine = (_, state) => state.numVertices < 100;
        const { userData } = await loadProgressive("/ranged.glb", new GLTFLoader(), { ranges: true, onRefine });
        await userData.loaded;
    });
    const less = ranges.asked.splice(0).reduce((sum, [from, end]) => sum + end - from, 0);
    assert.ok(less < 0.7 * ranged.length, `${less} of ${ranged.length}`);
});

test("a server that knows no ranges sends the file; one whose file changes is an error", async () => {
    const got = await page.evaluate(async () => {
        const { scene, userData } = await loadProgressive("/progressive.glb", new GLTFLoader(), { ranges: true });
        await userData.loaded;
        return compare(drawScene(scene), new Uint8Array(160000)).shown;
    });
    assert.ok(got > 3000, String(got));
    let release;
    ranges.held = new Promise(resolve => {
        release = resolve;
    });
    const failing = page.evaluate(async () => {
        const { userData } = await loadProgressive("/ranged.glb", new GLTFLoader(), { ranges: true });
        window.started = "ranged";
        return userData.loaded.then(() => "no error", String);
    });
    await page.waitForFunction(() => window.started === "ranged");
    ranges.tag = "b";
    release();
    assert.match(await failing, /ranged.glb has changed/);
    ranges.tag = "a";
});

test("100 loads do not take more memory than 20", async () => {
    const fresh = await open(),
        session = await browser.newBrowserCDPSession();
    const pids = async () =>
        (await session.send("SystemInfo.getProcessInfo")).processInfo
            .filter(p => p.type === "renderer")
            .map(p => p.id);
    const resident = async () =>
        (await pids()).reduce(
            (sum, pid) => sum + Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, "utf8"))[1]),
            0,
        );
    const load = count =>
        fresh.evaluate(async count => {
            const loader = new CQMLoader();
            for (let i = 0; i < count; i++) {
                loader.setWorkerLimit(i % 2);
                const geometry = await loader.loadAsync("/whole.cqm");
                await geometry.loaded;
                draw(geometry);
                geometry.dispose();
                if (i % 10 === 9) gc();
            }
            loader.dispose();
            gc();
        }, count);
    await load(20);
    let before = await resident(),
        grown = Infinity;
    for (let round = 0; round < 3 && grown > 20 * 1024; round++) {
        // a leak grows in each
        await load(100);
        grown = (await resident()) - before;
        before += grown;
    }
    await fresh.close();
    console.log(`${grown} KiB more after 100 loads, of ${before}`);
    assert.ok(grown < 20 * 1024, `${grown} KiB`);
});

test("nothing failed unseen", () => assert.deepEqual(problems, []));
