import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { describe, expect, it } from "vitest";
import { bundleSize, makeBundle } from "./bundle";

const files = [0, 1, 511, 512, 513, 70_000].map(
  (size, i) => new File([new Uint8Array(size).fill(i + 1)], `Name^Secret${i}.dcm`),
);

describe("the upload bundle", () => {
  it("is a tar archive of the files in order, with plain names and without owner or time", async () => {
    const folder = mkdtempSync(join(tmpdir(), "bundle-"));
    try {
      const path = join(folder, "b.tar");
      writeFileSync(path, Buffer.from(await makeBundle(files).arrayBuffer()));
      const list = spawnSync("tar", ["--numeric-owner", "--utc", "-tvf", path], {
        encoding: "utf8",
        env: { LC_ALL: "C", PATH: process.env.PATH },
      });
      expect(list.stderr).toBe("");
      const lines = list.stdout
        .trim()
        .split("\n")
        .map((line) => line.replace(/\s+/g, " "));
      expect(lines).toEqual(files.map((file, i) => `-rw-r--r-- 0/0 ${file.size} 1970-01-01 00:00 0000${i + 1}.dcm`));
      spawnSync("tar", ["-xf", path, "-C", folder]);
      files.forEach((file, i) =>
        expect([...new Set(readFileSync(join(folder, `0000${i + 1}.dcm`)))]).toEqual(file.size ? [i + 1] : []),
      );
    } finally {
      rmSync(folder, { recursive: true });
    }
  });

  it("has the announced length and contains no file name", async () => {
    const bundle = makeBundle(files);
    expect(bundle.size).toBe(bundleSize(files.map((file) => file.size)));
    expect(await bundle.text()).not.toContain("Secret");
  });

  it("is the same for the same files, so that an upload can continue", async () => {
    const again = await makeBundle([...files]).arrayBuffer();
    expect(Buffer.from(again).equals(Buffer.from(await makeBundle(files).arrayBuffer()))).toBe(true);
  });
});
