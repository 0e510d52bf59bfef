/* worker.js - decodes for a page: new Worker(new URL("conquest-mesh/worker.js", import.meta.url), { type: "module" }).
 * SPDX-License-Identifier: MIT */
import { serve } from "./conquest.js";

serve(/** @type {any} */ (globalThis));
