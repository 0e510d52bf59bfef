/* What node's tests print here: a line for each, and at the end `N passed, N failed`. SPDX-License-Identifier: MIT */
export default async function* report(source) {
    let passed = 0,
        failed = 0;
    for await (const { type, data } of source) {
        if (type === "test:stdout" || type === "test:stderr") yield data.message;
        if (type === "test:fail") {
            failed++;
            yield `FAIL ${data.name}: ${data.details.error.cause?.stack ?? data.details.error.message}\n`;
        }
        if (type === "test:pass" && data.details.type !== "suite") {
            if (data.skip === undefined && data.todo === undefined) passed++;
            yield `ok ${data.name} (${Math.round(data.details.duration_ms)} ms)\n`;
        }
    }
    yield `${passed} passed, ${failed} failed\n`;
}
