/* viewer.js - a mesh while it arrives, beside other codecs. SPDX-License-Identifier: MIT */
import {
    BufferAttribute,
    BufferGeometry,
    DirectionalLight,
    HemisphereLight,
    Mesh,
    MeshStandardMaterial,
    PerspectiveCamera,
    Scene,
    WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { decode, decodeAll, encode, openCodec } from "conquest-mesh";
import { ProgressiveGeometry, errorInPixels } from "conquest-mesh/three";
import { gunzip, gzip, meshoptDecode, meshoptEncode, openDraco } from "./codecs.js";
import { readMesh } from "./files.js";

const find = id => document.getElementById(id);
const status = find("status"),
    slider = find("bytes"),
    views = find("views");
const camera = new PerspectiveCamera(40, 4 / 3, 0.01, 100);
const material = new MeshStandardMaterial({ color: 0xd8a35a, roughness: 0.6, side: 2 }),
    plain = material.clone(); // without colors of vertices
const draco = openDraco(
    { createEncoderModule: window.DracoEncoderModule, createDecoderModule: window.DracoDecoderModule },
    { locateFile: name => `draco3d/${name}` },
);

const PACKET = 1400, // bytes
    BUDGET = 4; // milliseconds

const kilobytes = n => (n < 1000 ? `${n} B` : n < 1e6 ? `${(n / 1000).toFixed(1)} kB` : `${(n / 1e6).toFixed(2)} MB`);
const milliseconds = t => (t < 1000 ? `${Math.round(t)} ms` : `${(t / 1000).toFixed(2)} s`);

// -- Views: three pictures of one camera --

class View {
    constructor(id, material) {
        this.canvas = find(id).querySelector("canvas");
        this.output = find(id).querySelector("output");
        this.renderer = new WebGLRenderer({
            canvas: this.canvas,
            alpha: true,
            antialias: true,
            preserveDrawingBuffer: true,
        });
        this.scene = new Scene();
        const light = new DirectionalLight(0xffffff, 2.5);
        light.position.set(-1, 2, 3);
        this.scene.add(light, new HemisphereLight(0xffffff, 0x555566, 1.5));
        this.mesh = new Mesh(new BufferGeometry(), material);
        this.mesh.frustumCulled = false;
        this.scene.add(this.mesh);
    }

    show(geometry) {
        if (this.mesh.geometry !== geometry) this.mesh.geometry.dispose();
        this.mesh.geometry = geometry;
        this.isNew = true;
        requestFrame();
    }

    /** Draws, and waits until it is drawn: shaders are compiled then. */
    finish(geometry) {
        this.show(geometry);
        this.draw();
        const gl = this.renderer.getContext();
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    }

    draw() {
        this.isNew = false;
        const { clientWidth: width, clientHeight: height } = this.canvas,
            ratio = Math.min(devicePixelRatio, 2);
        if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
            this.renderer.setPixelRatio(ratio);
            this.renderer.setSize(width, height, false);
        }
        this.renderer.render(this.scene, camera);
    }
}

const ours = new View("ours", material),
    others = { draco: new View("draco", plain), meshopt: new View("meshopt", plain) },
    all = [ours, ...Object.values(others)];
const controls = new OrbitControls(camera, views);
views.style.touchAction = "pan-y"; // a finger that goes up or down moves the page
let drawing = false;

/** Draws the views that show something new. */
function requestFrame() {
    if (!drawing)
        requestAnimationFrame(() => {
            drawing = false;
            all.filter(view => view.isNew).forEach(view => view.draw());
            describe();
        });
    drawing = true;
}

function requestDraw() {
    all.forEach(view => (view.isNew = true));
    requestFrame();
}

controls.addEventListener("change", requestDraw);
new ResizeObserver(requestDraw).observe(views);

function frameCamera({ center, radius }) {
    camera.position
        .set(0.6, 0.45, 1)
        .normalize()
        .multiplyScalar(2.9 * radius)
        .add(center);
    [camera.near, camera.far] = [radius / 100, radius * 20];
    camera.updateProjectionMatrix();
    controls.target.copy(center);
    controls.update();
}

function plainGeometry({ index, positions }) {
    const geometry = new BufferGeometry();
    geometry.setIndex(new BufferAttribute(index, 1));
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    if (!material.flatShading) geometry.computeVertexNormals();
    return geometry;
}

/** A geometry of all of a state. */
function wholeGeometry(state) {
    const geometry = new ProgressiveGeometry();
    geometry.grow({ ...state, ranges: [] });
    return geometry;
}

/** What is to be seen, in words. */
function describe() {
    const geometry = ours.mesh.geometry,
        state = geometry.state;
    if (!state) return;
    const pixels = errorInPixels(state.error, geometry, { camera, height: ours.canvas.height });
    const error = state.complete
        ? "exact"
        : `error ${Number.isFinite(pixels) ? `at most ${pixels.toPrecision(2)} pixels` : "not known"}`;
    find("state").value =
        `${kilobytes(state.bytes)} of ${kilobytes(state.totalBytes)}, level ${state.level}, ` +
        `${state.numVertices.toLocaleString("en")} vertices, ${error}`;
    slider.value = state.bytes;
}

// -- One mesh: the stream, and what the others make of it --

let current = null,
    playing = { stop() {}, hold() {} };

/** A failure of one action: words for the user; the page goes on. */
function fail(error) {
    status.textContent = error.message;
    status.className = "error";
}

function say(text) {
    status.textContent = text;
    status.className = "";
}

/** Attributes that the other codecs get, too. */
const SHARED = ["normals", "texcoords"];

async function open(name, bytes) {
    playing.stop();
    say(`Decoding ${name}`);
    const state = await decodeAll(bytes),
        whole = wholeGeometry(state);
    const { positions, ...more } = state.attributes;
    if (!positions) throw new Error(`${name} has no positions`);
    const mesh = { index: state.index, positions: positions.array, bits: Math.min(positions.bits, 16) };
    for (const key of SHARED.filter(key => more[key])) mesh[key] = more[key].array;
    const lacks = Object.keys(more).filter(key => !SHARED.includes(key));
    if (state.numMaterials) lacks.push("materials");
    material.flatShading = plain.flatShading = !whole.hasAttribute("normal");
    material.vertexColors = whole.hasAttribute("color");
    material.needsUpdate = plain.needsUpdate = true;
    frameCamera(whole.boundingSphere);
    say(`Encoding ${name} by the other codecs`);
    await new Promise(resolve => setTimeout(resolve, 20));
    const meshopt = await meshoptEncode(mesh),
        drc = await draco,
        packed = await gzip(meshopt.bytes);
    const dracoBytes = drc.encode(mesh);
    current = {
        name,
        bytes,
        faces: state.numFaces,
        lacks: lacks.length ? `\nwithout ${lacks.join(", ")}` : "",
        draco: { size: dracoBytes.length, decode: async () => drc.decode(dracoBytes) },
        meshopt: {
            size: packed.length,
            decode: async () => meshoptDecode({ ...meshopt, bytes: await gunzip(packed) }),
        },
    };
    slider.max = bytes.length;
    await warmUp(whole);
    await play();
}

/** All that the clock is not to count: decoders are loaded and have run, shaders are compiled. */
async function warmUp(whole) {
    await openCodec();
    const { bytes } = current,
        packets = Array.from({ length: Math.ceil(bytes.length / PACKET) }, (_, k) =>
            bytes.subarray(k * PACKET, (k + 1) * PACKET),
        );
    for (let round = 0, end = performance.now() + 1000; round < 3 && performance.now() < end; round++) {
        const geometry = new ProgressiveGeometry();
        await refine(packets, { onState: state => geometry.grow(state) });
        for (const codec of Object.keys(others)) await current[codec].decode();
    }
    all.forEach(view => view.finish(whole));
}

/**
 * Bytes at the rate of a network, in packets; all that have arrived at once. Timers are set at the start, since browsers
 * let one that another has set wait for 4 milliseconds.
 */
function throttle(bytes, rate, signal) {
    const packet = Math.max(PACKET, bytes.length >> 10);
    let arrived = 0,
        sent = 0,
        wake = () => {};
    const arrive = count => {
        arrived = count;
        wake();
    };
    for (let end = packet; end < bytes.length + packet; end += packet)
        wait((Math.min(end, bytes.length) / rate) * 1000).then(() => arrive(Math.min(end, bytes.length)));
    signal.addEventListener("abort", () => wake());
    return new ReadableStream(
        {
            async pull(controller) {
                while (arrived === sent && !signal.aborted) await new Promise(resolve => (wake = resolve));
                controller.enqueue(bytes.slice(sent, arrived));
                sent = arrived;
                if (sent === bytes.length || signal.aborted) controller.close();
            },
        },
        { highWaterMark: 0 },
    );
}

const wait = time => new Promise(resolve => setTimeout(resolve, Math.ceil(time)));

/** Lets the page do what waits, a frame for one. */
function pause() {
    const { port1, port2 } = new MessageChannel();
    return new Promise(resolve => {
        port1.onmessage = () => {
            port1.close();
            resolve();
        };
        port2.postMessage(0);
    });
}

/** Draws what the decoder has after each packet and each budget; does not wait for frames. */
async function refine(source, { signal, onState }) {
    try {
        for await (const state of decode(source, { budget: BUDGET, signal })) {
            onState(state);
            await pause();
        }
    } catch (error) {
        if (!signal?.aborted) throw error;
    }
}

async function play() {
    playing.stop();
    const { name, bytes, faces, lacks } = current,
        rate = Number(find("rate").value),
        stopped = new AbortController(),
        held = new AbortController();
    playing = {
        stop: () => {
            stopped.abort();
            held.abort();
        },
        hold: () => held.abort(),
    };
    all.forEach(view => {
        view.finish(new BufferGeometry());
        view.output.value = "";
    });
    say(`${name}: ${faces.toLocaleString("en")} triangles`);
    const geometry = new ProgressiveGeometry();
    await Promise.race([new Promise(requestAnimationFrame), wait(100)]); // the page has been drawn
    await pause();
    const start = performance.mark("start").startTime,
        since = () => performance.now() - start;
    let first = 0;
    const onState = state => {
        geometry.grow(state);
        const now = since();
        first ||= now;
        ours.show(geometry);
        ours.output.value =
            `first picture after ${milliseconds(first)}\n` +
            (state.complete
                ? `exact after ${milliseconds(now)}, ${kilobytes(bytes.length)}`
                : `${kilobytes(state.bytes)}`);
    };
    await Promise.all([
        refine(throttle(bytes, rate, held.signal), { signal: held.signal, onState }),
        ...Object.entries(others).map(async ([codec, view]) => {
            const { size, decode } = current[codec];
            view.output.value = `0 B of ${kilobytes(size)}`;
            await wait((size / rate) * 1000);
            if (stopped.signal.aborted) return;
            const mesh = await decode(),
                now = since();
            if (stopped.signal.aborted) return;
            view.show(plainGeometry(mesh));
            view.output.value = `first picture after ${milliseconds(now)}\nexact after ${milliseconds(now)}, ${kilobytes(size)}${lacks}`;
        }),
    ]);
    if (!held.signal.aborted) document.body.dataset.done = name;
}

async function showPrefix() {
    playing.hold(); // the others go on
    ours.output.value = ours.output.value.replace(/\n(?=\d)/, "\nstopped at ");
    const count = Number(slider.value);
    const state = await decodeAll(current.bytes.subarray(0, count), { partial: true }).catch(() => null);
    if (count !== Number(slider.value)) return;
    if (!state) find("state").value = `${kilobytes(count)}: nothing to be seen yet`;
    ours.show(state ? wholeGeometry(state) : new BufferGeometry());
}

// -- Controls --

const run = action => {
    delete document.body.dataset.done;
    return action().catch(fail);
};

async function openFile(file) {
    const bytes = new Uint8Array(await file.arrayBuffer());
    if (/[.]cqm$/i.test(file.name)) return open(file.name, bytes);
    say(`Encoding ${file.name}`);
    await wait(20);
    return open(file.name, (await encode(readMesh(file.name, bytes))).data);
}

async function openListed() {
    const response = await fetch(`meshes/${find("meshes").value}`);
    if (!response.ok) throw new Error(`${response.url}: ${response.status}`);
    return open(find("meshes").value, new Uint8Array(await response.arrayBuffer()));
}

find("controls").addEventListener("submit", event => {
    event.preventDefault();
    if (current) run(play);
});
find("meshes").addEventListener("change", () => run(openListed));
find("rate").addEventListener("change", () => {
    if (current) run(play);
});
find("file").addEventListener("change", event => {
    if (event.target.files[0]) run(() => openFile(event.target.files[0]));
});
find("wireframe").addEventListener("change", event => {
    material.wireframe = plain.wireframe = event.target.checked;
    requestDraw();
});
slider.addEventListener("input", () => {
    if (current) run(showPrefix);
});
addEventListener("dragover", event => {
    event.preventDefault();
    document.body.classList.add("dragging");
});
addEventListener("dragleave", () => document.body.classList.remove("dragging"));
addEventListener("drop", event => {
    event.preventDefault();
    document.body.classList.remove("dragging");
    const [file] = event.dataTransfer.files;
    if (file) run(() => openFile(file));
});
ours.canvas.addEventListener("keydown", event => {
    const turn = { ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, -0.15], ArrowDown: [0, 0.15] }[
        event.key
    ];
    const scale = { "+": 0.85, "=": 0.85, "-": 1 / 0.85 }[event.key];
    if (!turn && !scale) return;
    event.preventDefault();
    const offset = camera.position.clone().sub(controls.target);
    if (turn) {
        const length = offset.length(),
            around = Math.atan2(offset.x, offset.z) + turn[0];
        const up = Math.min(1.5, Math.max(-1.5, Math.asin(offset.y / length) - turn[1]));
        offset
            .set(Math.sin(around) * Math.cos(up), Math.sin(up), Math.cos(around) * Math.cos(up))
            .multiplyScalar(length);
    }
    camera.position.copy(controls.target).add(offset.multiplyScalar(scale ?? 1));
    controls.update();
    requestDraw();
});

run(async () => {
    const names = await (await fetch("meshes/list.json")).json();
    find("meshes").append(...names.map(name => new Option(name.replace(/[.]cqm$/, ""), name)));
    await openListed();
});
