/* The page, in a browser: at a desk and on a phone, by mouse, keys and files. SPDX-License-Identifier: MIT */
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, test } from "node:test";
import { brotliCompressSync, gzipSync } from "node:zlib";
import { chromium } from "playwright-core";
import { encode } from "conquest-mesh";
import { countBytes } from "./counts.js";
import { makeSphere } from "./meshes.js";
import { serveFolder } from "./serve.js";

const server = await serveFolder("../site", 0);
const browser = await chromium.launch({
    executablePath: "/usr/bin/chromium",
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
after(async () => {
    await browser.close();
    server.close();
    server.closeAllConnections();
});

const address = `http://127.0.0.1:${server.address().port}`,
    problems = [],
    foreign = [];
async function open({ mesh, ...options } = {}) {
    const page = await browser.newPage(options);
    page.setDefaultTimeout(40000);
    page.on("pageerror", error => problems.push(String(error)));
    page.on("console", message => {
        if (message.type() === "error") problems.push(message.text());
    });
    page.on("request", request => {
        if (!/^(data|blob):/.test(request.url()) && !request.url().startsWith(address)) foreign.push(request.url());
    });
    if (mesh) await page.route("**/list.json", route => route.fulfill({ json: [mesh] }));
    await page.goto(address);
    return page;
}

const isDone = (page, name) => page.waitForFunction(name => document.body.dataset.done === name, name);
const texts = page =>
    page.evaluate(() =>
        Object.fromEntries(
            ["ours", "draco", "meshopt"].map(id => [id, document.querySelector(`#${id} output`).value]),
        ),
    );
/** Share of pixels that something is drawn in. */
const cover = (page, id = "ours") =>
    page.evaluate(id => {
        const from = document.querySelector(`#${id} canvas`),
            to = new OffscreenCanvas(from.width, from.height),
            context = to.getContext("2d");
        context.drawImage(from, 0, 0);
        const { data } = context.getImageData(0, 0, from.width, from.height);
        return data.filter((x, i) => i % 4 === 3 && x > 0).length / (data.length / 4);
    }, id);
const drop = (page, name, bytes) =>
    page.evaluate(
        async ([name, bytes]) => {
            const data = new DataTransfer();
            data.items.add(new File([Uint8Array.from(bytes)], name));
            dispatchEvent(new DragEvent("drop", { dataTransfer: data, cancelable: true }));
        },
        [name, Array.from(bytes)],
    );

/** Waits for a condition, at most 20 seconds; then it is a failure. */
async function until(condition) {
    const end = Date.now() + 20000;
    while (!(await condition())) {
        assert.ok(Date.now() < end, String(condition));
        await new Promise(resolve => setTimeout(resolve, 100));
    }
}

const page = await open({ viewport: { width: 1200, height: 800 } });

test("loads a mesh beside two other codecs", async () => {
    await isDone(page, "bunny00.cqm");
    await page.selectOption("#rate", "125000");
    await isDone(page, "bunny00.cqm");
    await page.waitForTimeout(200);
    const got = await texts(page);
    for (const text of Object.values(got))
        assert.match(text, /^first picture after [\d.]+ m?s\nexact after [\d.]+ m?s, [\d.]+ kB$/);
    const time = text => {
        const [, number, unit] = /^first picture after ([\d.]+) (m?s)/.exec(text);
        return number * (unit === "s" ? 1000 : 1);
    };
    assert.ok(time(got.ours) < 0.5 * time(got.draco), JSON.stringify(got));
    console.log(JSON.stringify(got));
    const shown = await Promise.all(["ours", "draco", "meshopt"].map(id => cover(page, id)));
    assert.ok(
        shown.every(x => x > 0.1 && Math.abs(x - shown[0]) < 0.005),
        String(shown),
    );
});

test("nothing is loaded while the clock runs; the decoders are there", async () => {
    const own = await open({ mesh: "elephant.cqm" });
    await isDone(own, "elephant.cqm");
    const { start, loaded } = await own.evaluate(() => ({
        start: performance.getEntriesByName("start")[0].startTime,
        loaded: performance.getEntriesByType("resource").map(r => [r.name, r.startTime]),
    }));
    await own.close();
    for (const file of ["/full.wasm.js", "/draco_decoder.wasm"])
        assert.ok(
            loaded.some(([name]) => name.endsWith(file)),
            file,
        );
    assert.deepEqual(
        loaded.filter(([, time]) => time > start),
        [],
    );
});

test("the slider stops the stream while it comes; the other codecs go on", async () => {
    await page.selectOption("#rate", "125000");
    await until(async () => (await texts(page)).ours.includes("\n"));
    await page.focus("#bytes");
    await page.keyboard.press("PageUp");
    assert.match((await texts(page)).draco, /^0 B of/);
    await until(async () => Object.values(await texts(page)).slice(1).every(text => text.includes("exact after")));
    assert.match((await texts(page)).ours, /\nstopped at [\d.]+ kB$/);
});

test("the slider shows what some bytes show; then it can be loaded again", async () => {
    await page.focus("#bytes");
    await page.evaluate(() => {
        const s = document.getElementById("bytes");
        s.value = 3000;
        s.dispatchEvent(new Event("input"));
    });
    await page.waitForFunction(() =>
        /^(2[.]9|3[.]0) kB of .*level \d+, [\d,]+ vertices, error at most [\d.e+]+ pixels$/.test(
            document.getElementById("state").value,
        ),
    );
    assert.ok((await cover(page)) > 0.1);
    for (const key of ["Home", "End"]) {
        await page.keyboard.press(key);
        await page.waitForFunction(
            key => (key === "Home" ? /nothing/ : /exact$/).test(document.getElementById("state").value),
            key,
        );
    }
    await page.selectOption("#rate", "12500000");
    await isDone(page, "bunny00.cqm");
});

test("wireframe, arrow keys and zoom change the picture", async () => {
    const full = await cover(page);
    for (let k = 0; k < 4; k++) await page.press("#ours canvas", "-");
    await until(async () => (await cover(page)) < 0.5 * full);
    const small = await cover(page);
    await page.check("#wireframe");
    await until(async () => (await cover(page)) !== small);
    await page.uncheck("#wireframe");
    await until(async () => (await cover(page)) === small);
    await page.press("#ours canvas", "ArrowLeft");
    await until(async () => (await cover(page)) !== small);
});

test("files: a stream, an OFF, a corrupt one, one that is none; the page lives", async () => {
    const sphere = makeSphere(),
        { data } = await encode(sphere);
    await drop(page, "sphere.cqm", data);
    await isDone(page, "sphere.cqm");
    const off = [
        `OFF\n${sphere.positions.length / 3} ${sphere.index.length / 3} 0`,
        ...Array.from({ length: sphere.positions.length / 3 }, (_, v) =>
            sphere.positions.subarray(3 * v, 3 * v + 3).join(" "),
        ),
        ...Array.from(
            { length: sphere.index.length / 3 },
            (_, f) => `3 ${sphere.index.subarray(3 * f, 3 * f + 3).join(" ")}`,
        ),
    ].join("\n");
    await drop(page, "ball.off", Buffer.from(off));
    await isDone(page, "ball.off");
    const isWhole = () =>
        page.waitForFunction(
            count => document.getElementById("state").value.includes(` ${count} vertices, exact`),
            (sphere.positions.length / 3).toLocaleString("en"),
        );
    await isWhole();
    const obj = [
        ...Array.from(
            { length: sphere.positions.length / 3 },
            (_, v) => `v ${sphere.positions.subarray(3 * v, 3 * v + 3).join(" ")}`,
        ),
        ...Array.from(
            { length: sphere.index.length / 3 },
            (_, f) => `f ${sphere.index.subarray(3 * f, 3 * f + 3).map(v => v + 1).join(" ")}`,
        ),
    ].join("\n");
    await drop(page, "ball.obj", Buffer.from(obj));
    await isDone(page, "ball.obj");
    await isWhole(); // no normals, no seams
    const colored = await encode({ ...sphere, colors: sphere.positions.map(x => Math.min(Math.abs(x), 1)) });
    await drop(page, "colored.cqm", colored.data);
    await isDone(page, "colored.cqm");
    assert.match((await texts(page)).draco, /\nwithout colors$/);
    const points =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
    const damaged = data.slice();
    damaged[damaged.length >> 1] ^= 8;
    for (const [name, bytes, words] of [
        ["damaged.cqm", damaged, /(corrupt stream|check value mismatch) \(byte \d+\)/],
        ["half.cqm", data.subarray(0, 900), /the input ends early \(byte \d+\)/],
        ["text.cqm", Buffer.from("hello, world"), /not a conquest stream/],
        ["a.xyz", Buffer.from("0 0 0"), /reads .cqm, .obj/],
        ["empty.off", Buffer.from("OFF\n0 0 0\n"), /empty.off has no faces/],
        ["cut.off", Buffer.from(off.slice(0, off.length >> 1)), /ends too early/],
        ["empty.obj", Buffer.from("v 0 0 0\n"), /empty.obj has no faces/],
        ["points.ply", Buffer.from(points), /points.ply has no faces/],
    ]) {
        await drop(page, name, bytes);
        await page.waitForFunction(() => document.getElementById("status").className === "error");
        assert.match(await page.textContent("#status"), words);
        await page.evaluate(() => {
            document.getElementById("status").className = "";
        });
    }
    await page.selectOption("#meshes", "fandisk.cqm");
    await isDone(page, "fandisk.cqm");
});

test("a phone's width, dark: nothing is cut off, all can be reached by keys", async () => {
    const phone = await open({
        viewport: { width: 360, height: 640 },
        colorScheme: "dark",
        isMobile: true,
        hasTouch: true,
        mesh: "fandisk.cqm",
    });
    await isDone(phone, "fandisk.cqm");
    const { width, ground, ink } = await phone.evaluate(() => ({
        width: document.documentElement.scrollWidth,
        ground: getComputedStyle(document.body).backgroundColor,
        ink: getComputedStyle(document.body).color,
    }));
    assert.equal(width, 360);
    assert.equal(await phone.evaluate(() => document.getElementById("views").style.touchAction), "pan-y");
    const light = colour =>
        colour
            .match(/\d+/g)
            .slice(0, 3)
            .reduce((a, x) => a + Number(x), 0);
    assert.ok(light(ground) < 150 && light(ink) > 600, `${ground}, ${ink}`);
    const reached = new Set();
    for (let k = 0; k < 10; k++) {
        await phone.keyboard.press("Tab");
        reached.add(await phone.evaluate(() => document.activeElement.id || document.activeElement.tagName));
    }
    assert.deepEqual(
        ["meshes", "file", "rate", "wireframe", "play", "CANVAS", "bytes"].filter(id => !reached.has(id)),
        [],
    );
    assert.ok((await cover(phone)) > 0.1);
    await phone.close();
});

test("README's picture tells the bytes of its stream", async () => {
    const [, text] = /!\[([^\]]*)\]\([^)]*bunny[.]png\)/.exec(readFileSync("../../../README.md", "utf8"));
    const told = text.match(/\d+(?: \d{3})*/g).map(n => Number(n.replaceAll(" ", "")));
    assert.deepEqual(told, await countBytes(readFileSync("../site/meshes/bunny00.cqm")), "run make readme-picture");
});

test("what a page fetches before a picture is small", () => {
    const sizes = file => {
        const data = readFileSync(file),
            compressed = brotliCompressSync(data).length;
        console.log(`${file}: ${data.length} bytes, ${compressed} by brotli, ${gzipSync(data, { level: 9 }).length} by gzip`);
        return compressed;
    };
    sizes("../decoder.wasm");
    const all = sizes("../site/conquest/decoder.wasm.js") + sizes("../site/conquest/conquest.js");
    console.log(`both: ${Math.round(all / 1e4)}0 kB by brotli`);
    assert.ok(all < 35000, String(all));
});

test("no other host was asked, nothing failed unseen", () => {
    assert.deepEqual(foreign, []);
    assert.deepEqual(problems, []);
});
