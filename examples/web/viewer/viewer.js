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
import { decodeAll, encode } from "conquest-mesh";
import { CQMLoader, ProgressiveGeometry, errorInPixels } from "conquest-mesh/three";
import { gunzip, gzip, meshoptDecode, meshoptEncode, openDraco } from "./codecs.js";
import { readMesh } from "./files.js";

const find = id => document.getElementById(id);
const status = find("status"),
    slider = find("bytes"),
    views = find("views");
const camera = new PerspectiveCamera(40, 4 / 3, 0.01, 100),
    loader = new CQMLoader().setWorkerLimit(1);
const material = new MeshStandardMaterial({ color: 0xd8a35a, roughness: 0.6, side: 2 });
const draco = openDraco(
    { createEncoderModule: window.DracoEncoderModule, createDecoderModule: window.DracoDecoderModule },
    { locateFile: name => `draco3d/${name}` },
);

const kilobytes = n => (n < 1000 ? `${n} B` : n < 1e6 ? `${(n / 1000).toFixed(1)} kB` : `${(n / 1e6).toFixed(2)} MB`);
const milliseconds = t => (t < 1000 ? `${Math.round(t)} ms` : `${(t / 1000).toFixed(2)} s`);

// -- Views: three pictures of one camera --

class View {
    constructor(id) {
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
        requestDraw();
    }

    draw() {
        const { clientWidth: width, clientHeight: height } = this.canvas,
            ratio = Math.min(devicePixelRatio, 2);
        if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
            this.renderer.setPixelRatio(ratio);
            this.renderer.setSize(width, height, false);
        }
        this.renderer.render(this.scene, camera);
    }
}

const ours = new View("ours"),
    others = { draco: new View("draco"), meshopt: new View("meshopt") },
    all = [ours, ...Object.values(others)];
const controls = new OrbitControls(camera, views);
views.style.touchAction = "pan-y"; // a finger that goes up or down moves the page
let drawing = false;

function requestDraw() {
    if (!drawing)
        requestAnimationFrame(() => {
            drawing = false;
            all.forEach(view => view.draw());
            describe();
        });
    drawing = true;
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
    playing = { stop() {} };

/** A failure of one action: words for the user; the page goes on. */
function fail(error) {
    status.textContent = error.message;
    status.className = "error";
}

function say(text) {
    status.textContent = text;
    status.className = "";
}

async function open(name, bytes) {
    playing.stop();
    say(`Decoding ${name}`);
    const whole = await loader.refine(bytes, () => {}).loaded,
        { state } = whole;
    if (!state.attributes.positions) throw new Error(`${name} has no positions`);
    const { array: positions, bits } = state.attributes.positions;
    const mesh = { index: state.index, positions, bits: Math.min(bits, 16) };
    material.flatShading = !whole.hasAttribute("normal");
    material.vertexColors = whole.hasAttribute("color");
    material.needsUpdate = true;
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
        draco: { size: dracoBytes.length, decode: async () => drc.decode(dracoBytes) },
        meshopt: {
            size: packed.length,
            decode: async () => meshoptDecode({ ...meshopt, bytes: await gunzip(packed) }),
        },
    };
    slider.max = bytes.length;
    await play();
}

/** Bytes at the rate of a network. */
function throttle(bytes, rate, signal) {
    const start = performance.now();
    let sent = 0;
    return new ReadableStream(
        {
            async pull(controller) {
                let due = 0;
                while (
                    (due = Math.min(bytes.length, Math.floor(((performance.now() - start) * rate) / 1000))) <= sent &&
                    sent < bytes.length &&
                    !signal.aborted
                )
                    await new Promise(resolve => setTimeout(resolve, 4));
                controller.enqueue(bytes.slice(sent, due));
                sent = due;
                if (sent === bytes.length || signal.aborted) controller.close();
            },
        },
        { highWaterMark: 0 },
    );
}

const wait = time => new Promise(resolve => setTimeout(resolve, time));

async function play() {
    playing.stop();
    const { name, bytes } = current,
        rate = Number(find("rate").value),
        abort = new AbortController(),
        start = performance.now();
    const isCurrent = () => !abort.signal.aborted,
        since = () => performance.now() - start;
    all.forEach(view => {
        view.show(new BufferGeometry());
        view.output.value = "";
    });
    let first = 0;
    loader.onRefine = (geometry, state) => {
        if (!isCurrent() || playing.geometry !== geometry) return;
        first ||= since();
        ours.show(geometry);
        ours.output.value =
            `first picture after ${milliseconds(first)}\n` +
            (state.complete
                ? `exact after ${milliseconds(since())}, ${kilobytes(bytes.length)}`
                : `${kilobytes(state.bytes)}`);
    };
    const geometry = loader.refine(throttle(bytes, rate, abort.signal), () => {});
    playing = {
        geometry,
        stop: () => {
            abort.abort();
            geometry.stop();
        },
    };
    say(`${name}: ${current.faces.toLocaleString("en")} triangles`);
    await Promise.all([
        geometry.loaded,
        ...Object.entries(others).map(async ([codec, view]) => {
            const { size, decode } = current[codec];
            view.output.value = `0 B of ${kilobytes(size)}`;
            await wait((size / rate) * 1000);
            if (!isCurrent()) return;
            const mesh = await decode();
            if (!isCurrent()) return;
            view.show(plainGeometry(mesh));
            view.output.value = `first picture after ${milliseconds(since())}\nexact after ${milliseconds(since())}, ${kilobytes(size)}`;
        }),
    ]);
    if (isCurrent()) document.body.dataset.done = name;
}

async function showPrefix() {
    playing.stop();
    const count = Number(slider.value);
    const state = await decodeAll(current.bytes.subarray(0, count), { partial: true }).catch(() => null);
    if (count !== Number(slider.value)) return;
    const geometry = state ? new ProgressiveGeometry() : new BufferGeometry();
    if (state) geometry.grow({ ...state, ranges: [] });
    else find("state").value = `${kilobytes(count)}: nothing to be seen yet`;
    ours.show(geometry);
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
    material.wireframe = event.target.checked;
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
