/* worker.js - decodes for a page: new Worker(new URL("conquest-mesh/worker.js", import.meta.url), { type: "module" }); in
 * node, of node:worker_threads: new Worker(new URL(import.meta.resolve("conquest-mesh/worker.js"))).
 * SPDX-License-Identifier: MIT */
import { serve } from "./conquest.js";

serve();
