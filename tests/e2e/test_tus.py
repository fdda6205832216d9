"""tus 1.0 with a standard client: plain tus-js-client in Chromium, from creation to termination, against the real edge and api.
The page uses the same client, here without Diaphane's code around it."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from harness import REPO, StackFactory, TestStack
from person import Person
from test_upload import Dam

CLIENT = REPO / "frontend" / "node_modules" / "tus-js-client" / "dist" / "tus.min.js"
PART = 8 * 1024 * 1024

# Reproducible bytes, and `tus.Upload` with the page's token and a test's options.
SETUP = """async () => {
  const { csrf_token } = await (await fetch("/v1/me")).json();
  window.bytes_of = (length, seed) => {
    const bytes = new Uint8Array(length);
    let state = seed;
    for (let i = 0; i < length; i++) bytes[i] = (state = (Math.imul(state, 1103515245) + 12345) >>> 0) >>> 16;
    return new File([bytes], "Mustermann^Max.tar", { lastModified: 1 });
  };
  window.begin = (length, seed, options) => {
    const run = { offsets: [], error: null, upload: null };
    run.done = new Promise((resolve, reject) => {
      run.upload = new tus.Upload(bytes_of(length, seed), {
        endpoint: "/v1/uploads", chunkSize: 8 * 1024 * 1024, retryDelays: [100, 500, 1000, 2000, 4000, 4000, 4000],
        headers: { "X-CSRF-Token": csrf_token }, metadata: { title: "By another client", filename: "Mustermann^Max.tar", filetype: "application/x-tar" },
        onBeforeRequest: (request) => { if (request.getMethod() === "PATCH") run.offsets.push(Number(request.getHeader("Upload-Offset"))); },
        onSuccess: () => resolve(run.upload.url), onError: (error) => reject(error), ...options });
    });
    run.done.catch((error) => { run.error = error.originalResponse ? error.originalResponse.getStatus() : String(error); });
    return run;
  };
}"""


def bytes_of(length: int, seed: int) -> bytes:
    made, state = bytearray(length), seed
    for i in range(length):
        state = (state * 1103515245 + 12345) & 0xFFFFFFFF
        made[i] = (state >> 16) & 0xFF
    return bytes(made)


@pytest.fixture(scope="module")
def tus_stack(all_stacks: StackFactory):
    """Without ingestd, so that uploads stay and can be inspected."""
    stack = all_stacks.open(only=("postgres", "redis", "api", "edge"), extra_env={"DIAPHANE_MAX_UPLOAD_MB": "64"})
    yield stack
    all_stacks.shut(stack)


@pytest.fixture
def page(tus_stack: TestStack, visit) -> Page:
    page = visit()
    Person.arrives(tus_stack, page, "tus")
    return with_client(page)


def with_client(page: Page) -> Page:
    page.evaluate(CLIENT.read_text(encoding="utf-8"))
    page.evaluate(SETUP)
    return page


def file_of(stack: TestStack, url: str) -> Path:
    return stack.data_dir / "uploads" / f"{url.rsplit('/', 1)[1]}.tar"


def same_bytes(stack: TestStack, url: str, length: int, seed: int) -> bool:
    stored = file_of(stack, url).read_bytes()
    return len(stored) == length and hashlib.sha256(stored).digest() == hashlib.sha256(bytes_of(length, seed)).digest()


def test_a_plain_tus_client_uploads_several_files_in_parallel(tus_stack: TestStack, page: Page):
    assert page.evaluate("tus.isSupported")
    urls = page.evaluate("""() => {
        const runs = [1, 2, 3].map((seed) => begin(400000 + seed, seed));
        runs.forEach((run) => run.upload.start());
        return Promise.all(runs.map((run) => run.done));
    }""")
    assert len(set(urls)) == 3
    for seed, url in enumerate(urls, 1):
        assert same_bytes(tus_stack, url, 400000 + seed, seed)
        data_set = url.rsplit("/", 1)[1]
        assert tus_stack.psql("SELECT title, state FROM data_sets WHERE id = %s", data_set) == [("By another client", "queued")]
    # Nothing that such a client sends about its file by default is stored.
    assert "Mustermann" not in "".join(tus_stack.log(program) for program in ("api", "edge"))


def test_an_upload_survives_killing_the_server(tus_stack: TestStack, page: Page):
    length = 3 * PART + 1234
    page.evaluate("(length) => { window.run = begin(length, 7); run.upload.start(); }", length)
    tus_stack.wait_until(lambda: page.evaluate("run.offsets.length") >= 2, what="the second part")
    # This client starts again if it asks too early. A client that asks once the server is back finds everything that had arrived.
    page.evaluate("run.upload.abort()")
    tus_stack.kill("api")
    tus_stack.wait_ready("api")
    page.evaluate("run.upload.start()")
    url = page.evaluate("run.done")
    assert same_bytes(tus_stack, url, length, 7)
    assert page.evaluate("run.offsets").count(0) == 1  # received parts are not sent again


def test_the_page_survives_an_outage_of_the_server(tus_stack: TestStack, visit, cranium: Path):
    page = visit()
    person = Person.arrives(tus_stack, page, "restart")
    parts = []
    page.on("request", lambda request: parts.append(request.headers.get("upload-offset", "")) if request.method == "PATCH" else None)
    dam = Dam(page)
    person.upload(cranium, "Survivor")
    dam.wait(tus_stack)
    expect(person.card("Survivor")).to_be_visible()
    tus_stack.kill("api", restart=False)
    dam.opens()
    expect(person.card("Survivor")).to_contain_text("The upload will resume automatically")
    tus_stack.start("api")
    expect(person.card("Survivor")).to_have_attribute("data-state", "queued")
    # What had arrived is not sent again, and the part that was under way is.
    assert parts.count("0") == 1 and max(map(parts.count, parts)) >= 2
    assert person.card("Survivor").count() == 1


def test_a_restarted_browser_resumes_the_upload(tus_stack: TestStack, page: Page):
    length = 2 * PART + 99
    page.evaluate("""(length) => new Promise((resolve) => {
        window.run = begin(length, 9, { onChunkComplete: () => { run.upload.abort(); resolve(); } });
        run.upload.start();
    })""", length)
    # Another window of the same browser, as after a restart: only what the client stored is left.
    again = page.context.new_page()
    page.close()
    again.goto(tus_stack.url)
    with_client(again)
    found = again.evaluate("""async (length) => {
        window.run = begin(length, 9);
        const earlier = await run.upload.findPreviousUploads();
        run.upload.resumeFromPreviousUpload(earlier[0]);
        run.upload.start();
        return { earlier: earlier.length, url: await run.done, offsets: run.offsets };
    }""", length)
    assert found["earlier"] == 1
    assert found["offsets"] == [PART, 2 * PART]
    assert same_bytes(tus_stack, found["url"], length, 9)


def test_a_terminated_upload_is_not_found(tus_stack: TestStack, page: Page):
    url = page.evaluate("""() => new Promise((resolve, reject) => {
        window.run = begin(2 * 8388608, 11, { onChunkComplete: () => run.upload.abort(true).then(() => resolve(run.upload.url), reject) });
        run.upload.start();
    })""")
    status = page.evaluate("(url) => fetch(url, { method: 'HEAD', headers: { 'Tus-Resumable': '1.0.0' } }).then((r) => r.status)", url)
    assert status == 404
    tus_stack.wait_until(lambda: not file_of(tus_stack, url).exists(), what="the file's disposal")


def test_an_expired_upload_is_restarted(tus_stack: TestStack, page: Page):
    old = page.evaluate("""() => new Promise((resolve) => {
        window.run = begin(8388608 + 5, 13, { onChunkComplete: () => { run.upload.abort(); resolve(run.upload.url); } });
        run.upload.start();
    })""")
    tus_stack.psql("UPDATE uploads SET expires_at = now() - interval '1 second' WHERE id = %s", old.rsplit("/", 1)[1])
    new = page.evaluate("""async () => {
        window.again = begin(8388608 + 5, 13);
        again.upload.resumeFromPreviousUpload((await again.upload.findPreviousUploads())[0]);
        again.upload.start();
        return again.done;
    }""")
    assert new != old and same_bytes(tus_stack, new, 8388608 + 5, 13)
    tus_stack.wait_until(lambda: not file_of(tus_stack, old).exists(), what="the disposal of the expired one")


@pytest.mark.parametrize("options, status", [
    pytest.param("{ length: 65 * 1048576 }", 413, id="too large"),
    pytest.param("{ metadata: { filetype: 'application/zip' } }", 415, id="no tar"),
    pytest.param("{ metadata: { title: 'x'.repeat(81) } }", 422, id="a title too long"),
    pytest.param("{ uploadLengthDeferred: true }", 422, id="length left for later"),
    pytest.param("{ uploadDataDuringCreation: true }", 422, id="bytes before they are wanted"),
    pytest.param("{ headers: {} }", 403, id="no token"),
])
def test_an_upload_over_the_limit_is_refused_before_the_first_byte(tus_stack: TestStack, page: Page, options: str, status: int):
    before = set(os.listdir(tus_stack.data_dir / "uploads"))
    page.evaluate(f"""() => {{
        const options = {options};
        window.run = begin(options.length ?? 1000, 17, {{ ...options, retryDelays: null }});
        run.upload.start();
        return run.done.catch(() => undefined);
    }}""")
    assert page.evaluate("run.error") == status
    assert page.evaluate("run.offsets") == []
    # Nothing new. What earlier tests left may be disposed of meanwhile.
    assert set(os.listdir(tus_stack.data_dir / "uploads")) <= before
