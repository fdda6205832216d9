"""The measurement of attacks, without any attack: what it compares, and what its attackers send."""

from __future__ import annotations

import zlib

from harness import REPO  # noqa: F401 - puts tools/ on the path
from devtool.benches.abuse import Phase, results_of
from devtool.benches.support import abuse_clients


def met(results) -> dict[str, bool | None]:
    return {one.name: one.met for one in results}


def test_verdict_compares_each_attack_with_the_quiet_period_before_it():
    calm = [Phase(delays_ms=[10.0] * 100), Phase(delays_ms=[20.0] * 100), Phase(delays_ms=[10.0] * 100)]
    attacked = [Phase(delays_ms=[14.0] * 100), Phase(delays_ms=[28.0] * 100), Phase(delays_ms=[90.0] * 100)]
    results = results_of(calm, attacked, [])
    ratio = next(one for one in results if one.name == "p95 under attack / calm")
    assert ratio.value == 1.4 and ratio.met and ratio.spread > 0
    attacked[0].delays_ms = [16.0] * 100
    attacked[1].delays_ms = [32.0] * 100
    assert met(results_of(calm, attacked, []))["p95 under attack / calm"] is False


def test_a_failed_request_or_a_crashed_program_misses_the_target():
    calm, attacked = [Phase(delays_ms=[10.0])], [Phase(delays_ms=[10.0])]
    assert all(one is not False for one in met(results_of(calm, attacked, [])).values())
    assert met(results_of(calm, attacked, ["api"]))["programs that exited"] is False
    attacked[0].failures.append("/v1/me: 503")
    assert met(results_of(calm, attacked, []))["failed requests of ordinary users"] is False


def test_textures_are_small_distinct_files_with_many_pixels():
    first, second = abuse_clients.texture(1), abuse_clients.texture(2)
    assert first != second and len(first) < 10_000 and first[:8] == b"\x89PNG\r\n\x1a\n"
    rows = zlib.decompress(first[first.index(b"IDAT") + 4:-16])
    assert len(rows) == 4096 * (1 + 4096 // 8)


def test_attackers_refuse_to_connect_to_other_machines():
    try:
        abuse_clients.Attack({"url": "http://example.org:80", "seconds": 1})
    except SystemExit as refused:
        assert "this machine" in str(refused)
    else:
        raise AssertionError("it would have attacked example.org")
