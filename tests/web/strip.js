/* README's picture: what 1, 5, 20 and 100 % of a stream's bytes show, in Chromium; and their numbers in its text there:
 * node strip.js STREAM TO.png README.md. SPDX-License-Identifier: MIT */
import { readFileSync, writeFileSync } from "node:fs";
import { chromium } from "playwright-core";
import { countBytes } from "./counts.js";
import { serveFolder } from "./serve.js";

const [file, to, readme] = process.argv.slice(2),
    data = readFileSync(file),
    counts = await countBytes(data);
const server = await serveFolder("..", 0, { "/stream": (_, response) => response.end(data) });
const browser = await chromium.launch({
    executablePath: "/usr/bin/chromium",
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
const page = await browser.newPage({ viewport: { width: 1000, height: 300 } });
await page.goto(`http://127.0.0.1:${server.address().port}/test/browser.html`);
await page.waitForFunction("window.ready");
await page.evaluate(async counts => {
    const bytes = new Uint8Array(await (await fetch("/stream")).arrayBuffer()),
        renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    renderer.setSize(500, 500, false);
    document.body.style =
        "margin: 0; display: flex; background: #fff; color: #222; font: 15px sans-serif; text-align: center";
    const scene = new THREE.Scene(),
        light = new THREE.DirectionalLight(0xffffff, 2.5);
    light.position.set(-1, 2, 3);
    scene.add(light, new THREE.HemisphereLight(0xffffff, 0x555566, 1.5));
    const whole = await conquest.decodeAll(bytes),
        sphere = new ProgressiveGeometry();
    sphere.grow({ ...whole, ranges: [] });
    const { center, radius } = sphere.boundingSphere,
        camera = new THREE.PerspectiveCamera(36, 1, radius / 100, 10 * radius);
    camera.position
        .set(0.4, 0.35, 1)
        .normalize()
        .multiplyScalar(2.9 * radius)
        .add(center);
    camera.lookAt(center);
    for (const count of counts) {
        const state = await conquest.decodeAll(bytes.subarray(0, count), { partial: true });
        const geometry = new ProgressiveGeometry(),
            material = new THREE.MeshStandardMaterial({ color: 0xd8a35a, roughness: 0.6, flatShading: true, side: 2 });
        geometry.grow({ ...state, ranges: [] });
        const mesh = new THREE.Mesh(geometry, material),
            figure = document.createElement("figure"),
            image = new Image(),
            caption = document.createElement("figcaption");
        scene.add(mesh);
        renderer.render(scene, camera);
        scene.remove(mesh);
        image.src = renderer.domElement.toDataURL();
        await image.decode();
        image.style = "width: 250px; display: block";
        figure.style = "margin: 0; width: 250px";
        caption.textContent = `${Math.round((100 * count) / bytes.length)} %: ${count.toLocaleString("en")} bytes`;
        figure.append(image, caption);
        document.body.append(figure);
    }
}, counts);
await page.screenshot({ path: to });
await browser.close();
server.close();
server.closeAllConnections();

const [first, ...more] = counts.map(count => count.toLocaleString("en").replaceAll(",", " ")),
    last = more.pop(),
    text = `The Stanford bunny, drawn from its first ${first}, ${more.join(" and ")} bytes, and from all ${last}`;
writeFileSync(readme, readFileSync(readme, "utf8").replace(/!\[[^\]]*\](?=\([^)]*bunny[.]png\))/, `![${text}]`));
console.log(text);
