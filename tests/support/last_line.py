"""A plugin of pytest: the last line that every test of this project has. SPDX-License-Identifier: MIT"""


def pytest_unconfigure(config):
    stats = config.pluginmanager.get_plugin("terminalreporter").stats
    failed = sum(len(stats.get(name, ())) for name in ("failed", "error", "skipped", "xfailed", "xpassed"))
    print(f"\n{len(stats.get('passed', ()))} passed, {failed} failed")
