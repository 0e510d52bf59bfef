/* serve.js - shows a folder on a loopback port: node serve.js FOLDER [PORT]. SPDX-License-Identifier: MIT */
import { createReadStream } from "node:fs";
import { stat } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, normalize, resolve, sep } from "node:path";
import { fileURLToPath } from "node:url";

const TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript",
    ".mjs": "text/javascript",
    ".css": "text/css",
    ".json": "application/json",
    ".wasm": "application/wasm",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".glb": "model/gltf-binary",
};

/** What a Range header asks for: [first, last]; all if it is none that is known. */
function readRange(header, size) {
    const [, first, last] = /^bytes=(\d+)-(\d*)$/.exec(header ?? "") ?? [];
    const isValid = first !== undefined && Number(first) < size && (last === "" || Number(first) <= Number(last));
    return isValid ? [Number(first), last ? Math.min(Number(last), size - 1) : size - 1] : null;
}

async function respond(root, request, response) {
    const path = normalize(decodeURIComponent(new URL(request.url, "http://localhost").pathname));
    const file = join(root, path.endsWith(sep) ? join(path, "index.html") : path);
    const found = file.startsWith(root + sep) && (await stat(file).catch(() => null));
    if (!found || !found.isFile()) return response.writeHead(404).end("no such file\n");
    const range = readRange(request.headers.range, found.size),
        [first, last] = range ?? [0, found.size - 1];
    response.writeHead(range ? 206 : 200, {
        "content-type": TYPES[extname(file)] ?? "application/octet-stream",
        "content-length": last - first + 1,
        "accept-ranges": "bytes",
        ...(range && { "content-range": `bytes ${first}-${last}/${found.size}` }),
    });
    return found.size ? createReadStream(file, { start: first, end: last }).pipe(response) : response.end();
}

/** Serves a folder; `routes` are functions by path that come first. */
export function serveFolder(folder, port, routes = {}) {
    const root = resolve(folder);
    const server = createServer((request, response) => {
        const route = routes[new URL(request.url, "http://localhost").pathname];
        Promise.resolve(route ? route(request, response) : respond(root, request, response)).catch(() =>
            response.writeHead(400).end(),
        );
    });
    return new Promise(done => server.listen(port, "127.0.0.1", () => done(server)));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
    const server = await serveFolder(process.argv[2], Number(process.argv[3] ?? 8000));
    console.log(`http://127.0.0.1:${server.address().port}/`);
}
