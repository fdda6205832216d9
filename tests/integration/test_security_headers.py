"""The restrictions that every response imposes on the browser, none of which the page needs to violate."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import httpx
import pytest
from api_client import api, person  # noqa: F401
from harness import REPO

PATHS = ("/", "/account", "/reset", "/admin", "/v1/me", "/v1/admin/users", "/v1/nothing", "/none.js", "/v1/me/export/file")


def policy_of(answer: httpx.Response) -> dict[str, list[str]]:
    parts = (part.split() for part in answer.headers["content-security-policy"].split(";"))
    return {words[0]: words[1:] for words in parts if words}


@pytest.mark.parametrize("path", PATHS)
def test_every_response_has_a_strict_content_security_policy(api, path):  # noqa: F811
    answer = httpx.get(api.url + path, timeout=30)
    policy = policy_of(answer)
    assert policy["default-src"] == ["'none'"] and policy["script-src"] == ["'self'"] and policy["style-src"] == ["'self'"]
    assert policy["base-uri"] == ["'none'"] and policy["frame-ancestors"] == ["'none'"] and policy["form-action"] == ["'self'"]
    assert not re.search(r"unsafe|\*|http:|https:|data:", " ".join(policy["script-src"] + policy["style-src"] + policy["connect-src"]))
    assert answer.headers["x-content-type-options"] == "nosniff" and answer.headers["x-frame-options"] == "DENY"
    assert answer.headers["referrer-policy"] == "no-referrer"
    assert answer.headers["cross-origin-opener-policy"] == answer.headers["cross-origin-resource-policy"] == "same-origin"
    assert "camera=()" in answer.headers["permissions-policy"]
    assert not [name for name in answer.headers if name.startswith("access-control-")], "no other page may read it"
    if path.startswith("/v1/"):
        assert answer.headers["cache-control"] == "no-store"
    for header in ("server",):
        assert not re.search(r"\d", answer.headers.get(header, "")), "no version"


@pytest.mark.parametrize("path", ["/", "/view/8f6c2c0e-0000-4000-8000-000000000000"])
def test_a_preview_of_a_link_shows_the_same_picture_for_every_page(api, path):  # noqa: F811
    host = httpx.URL(api.url).netloc.decode()
    pictures = re.findall(r'property="og:image" content="([^"]*)"', httpx.get(api.url + path, timeout=30).text)
    assert pictures == [f"https://{host}/preview.jpg"]
    answer = httpx.get(api.url + "/preview.jpg", timeout=30)
    assert answer.status_code == 200 and answer.headers["content-type"] == "image/jpeg"


class Inline(HTMLParser):
    """Collects everything in a page that a strict policy would block."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []
        self.inside = ""

    def handle_starttag(self, tag, attributes):
        named = dict(attributes)
        self.inside = tag if tag in ("script", "style") and "src" not in named else ""
        self.found += [f"<{tag} {name}>" for name in named if name.startswith("on") or name == "style"]
        self.found += [f"<{tag} {name}={value}>" for name, value in attributes if (value or "").strip().lower().startswith("javascript:")]

    def handle_endtag(self, tag):
        self.inside = ""

    def handle_data(self, data):
        if self.inside and data.strip():
            self.found.append(f"<{self.inside}>: {data.strip()[:60]}")


def test_the_page_has_no_inline_scripts_or_styles():
    pages = [REPO / "frontend" / "index.html", *(REPO / "frontend" / "dist").glob("*.html")]
    for page in pages:
        parser = Inline()
        parser.feed(page.read_text(encoding="utf-8"))
        assert parser.found == [], page
    for source in (REPO / "frontend" / "src").rglob("*.ts*"):
        text = source.read_text(encoding="utf-8")
        assert not re.search(r"dangerouslySetInnerHTML|\.innerHTML|\beval\(|new Function\(|document\.write", text), source


def test_the_session_cookie_is_http_only_and_same_site(api):  # noqa: F811
    one = person(api)
    answer = one.http.post("/v1/me/password", json={"current": "a long and quiet password", "password": "another long and quiet one"})
    assert answer.status_code == 204 and "set-cookie" not in answer.headers
    again = httpx.post(api.url + "/v1/sign-in", json={"email": one.email, "password": "another long and quiet one"}, timeout=30)
    assert {"HttpOnly", "SameSite=Strict", "Path=/"} <= {part.strip() for part in again.headers["set-cookie"].split(";")}
