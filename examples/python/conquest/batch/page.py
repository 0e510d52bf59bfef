"""The table and the page of a run. SPDX-License-Identifier: MIT"""

from __future__ import annotations

import io
from dataclasses import asdict
from urllib.parse import quote

import jinja2  # type: ignore[import-not-found, unused-ignore]
import pyarrow  # type: ignore[import-untyped, import-not-found, unused-ignore]
import pyarrow.csv  # type: ignore[import-untyped, import-not-found, unused-ignore]
import pyarrow.parquet  # type: ignore[import-untyped, import-not-found, unused-ignore]

from .task import Row

SCHEMA = pyarrow.schema([(name, pyarrow.string()) for name in ("file", "sha256")]
                        + [(name, pyarrow.int64()) for name in ("file_bytes", "vertices", "faces", "bytes")]
                        + [("ratio", pyarrow.float64()), ("set_aside", pyarrow.int64()), ("told", pyarrow.string()),
                           ("error", pyarrow.string())])
WRITERS = {"csv": pyarrow.csv.write_csv, "parquet": pyarrow.parquet.write_table}

PAGE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<title>{{ title }}</title>
<style>
body { font: 15px/1.4 system-ui, sans-serif; margin: 2em auto; max-width: 75em; padding: 0 1em; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: right; padding: 0.2em 0.8em; border-bottom: 1px solid #8884; font-variant-numeric: tabular-nums; }
th:first-child, td:first-child, .left { text-align: left; }
img { width: 80px; height: 80px; display: block; }
.error { color: #c22; text-align: left; }
.told { color: #888; font-size: 0.85em; }
</style>
<h1>{{ title }}</h1>
<p>{{ rows | length }} files, {{ failed }} with an error; {{ "{:,}".format(before) }} bytes in files,
{{ "{:,}".format(after) }} in streams.</p>
<table>
<tr><th><th class="left">file<th>vertices<th>faces<th>bytes<th>ratio<th>set aside</tr>
{% for row in rows %}
<tr>{% if row.error %}<td><td class="left">{{ row.file }}<td class="error" colspan="5">{{ row.error }}
{% else %}<td><img src="{{ quote(row.file) }}.png" alt="" loading="lazy">
<td class="left"><a href="{{ quote(row.file) }}.cqm">{{ row.file }}</a>
{% if row.told %}<div class="told">{{ row.told }}</div>{% endif %}<td>{{ "{:,}".format(row.vertices) }}
<td>{{ "{:,}".format(row.faces) }}<td>{{ "{:,}".format(row.bytes) }}<td>{{ "%.1f" % row.ratio }}<td>{{ row.set_aside }}
{% endif %}</tr>
{% endfor %}
</table>
</html>
"""


def make_table(rows: list[Row], kind: str) -> bytes:
    """A file of the kind "csv" or "parquet"."""
    file = io.BytesIO()
    WRITERS[kind](pyarrow.Table.from_pylist([asdict(row) for row in rows], SCHEMA), file)
    return file.getvalue()


def make_page(rows: list[Row], title: str) -> bytes:
    good = [row for row in rows if not row.error]
    page = jinja2.Environment(autoescape=True, trim_blocks=True).from_string(PAGE)
    text: str = page.render(rows=rows, title=title, quote=quote, failed=len(rows) - len(good),
                            before=sum(row.file_bytes or 0 for row in good),
                            after=sum(row.bytes or 0 for row in good))
    return text.encode()
