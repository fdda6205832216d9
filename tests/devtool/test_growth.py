"""The exponents that `./diaphane bench growth` computes from its rows."""

from devtool.benches import growth


def report(voxel_power, pixel_power):
    def row(n, width, height, walk, milliseconds, to_target=True):
        reached = {"milliseconds": 3 * milliseconds, "samples": 3, "how": "between"} if to_target else None
        return {"volume": f"{n}^3", "size": [n, n, n], "width": width, "height": height, "walk": walk,
                "pass_in_a_row_ms": milliseconds, "to_target": reached}

    rows = []
    for walk, factor in (("exact", 5), ("tracking", 1)):
        rows += [row(n, 512, 512, walk, factor * float(n ** 3) ** voxel_power) for n in (256, 512, 1024)]
        rows += [row(512, 640 * k, 360 * k, walk, factor * float(k * k) ** pixel_power, k < 3) for k in (1, 2, 3, 6)]
    rows.append({"volume": "512^3", "size": [512] * 3, "width": 64, "height": 36, "walk": "exact", "left_out": "not here"})
    return {"engine": "cuda", "rows": rows}


def test_exponents_of_voxels_and_pixels_are_fitted_from_their_own_rows():
    found = {r.name: r.value for r in growth.results_of(report(0.3, 0.9))}
    for walk in ("exact", "tracking"):
        for what in ("time per pass", "time to the target"):
            assert abs(found[f"cuda, {walk}, voxels: {what}, exponent of the voxel count"] - 0.3) < 1e-9
            assert abs(found[f"cuda, {walk}, 512^3: {what}, exponent of the pixel count"] - 0.9) < 1e-9
    assert len(found) == 8


def test_a_single_point_has_no_exponent():
    alone = report(0.3, 0.9)
    alone["rows"] = alone["rows"][:1]
    assert growth.results_of(alone) == []
