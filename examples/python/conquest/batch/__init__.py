"""A tree of mesh files to streams, on all cores or on a cluster. SPDX-License-Identifier: MIT

    pip install 'conquest[batch]'
    python -m conquest.batch IN_DIR OUT_DIR
    python -m conquest.batch IN_DIR OUT_DIR --scheduler tcp://10.0.0.1:8786

For IN_DIR/a/b.obj, OUT_DIR gets a/b.obj.cqm, a picture a/b.obj.png and a record a/b.obj.json, each complete or absent;
and at the end table.csv (or table.parquet) and index.html with a row for each file, also for those that could not be
read, and what was dropped or changed. What is unchanged since the last run, by its hash and the options, is left as it is: a run that was interrupted
is continued by the same command. On a cluster all machines see both directories under the same names.

    task.py    one file, as a worker does it      page.py    the table and the page
    read.py    what other readers can read        run.py     all files, by dask's scheduler
"""

from .run import run

__all__ = ["run"]
