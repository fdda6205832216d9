"""What a user does with the pages, using only what is written on them."""

from __future__ import annotations

import re
import secrets
from dataclasses import dataclass
from pathlib import Path

import pyotp
from playwright.sync_api import Page, expect

from harness import TestStack
from seeds import give_scan, write_person

#: Maximum wait for a state. On two cores shared with builds and other tests, a part of an upload or a picture takes many times as
#: long as on idle ones.
PATIENCE_MS = 120_000
PASSWORD = "three blind mice run"
LINK = re.compile(r"http\S+/verify#token=[0-9a-f]{64}")

#: Returns the response to a request of this user's browser. Raises an error unless it succeeds.
POST = """async ([path, body]) => {
    const me = await (await fetch("/v1/me")).json();
    const headers = { "X-CSRF-Token": me.csrf_token, "Content-Type": "application/json" };
    const answer = await fetch(path, { method: "POST", headers, body: JSON.stringify(body) });
    if (!answer.ok) throw new Error(`${path}: ${answer.status} ${await answer.text()}`);
    return answer.json();
}"""


@dataclass
class Person:
    """A user with an account, in front of a page."""

    stack: TestStack
    page: Page
    email: str

    @staticmethod
    def arrives(stack: TestStack, page: Page, name: str) -> Person:
        """A user who already has an account and is signed in, at the list of scans."""
        person = Person(stack, page, f"{name}-{secrets.token_hex(4)}@example.org")
        token = write_person(stack.psql, person.email, password=PASSWORD).token
        page.context.add_cookies([{"name": "diaphane", "value": token, "url": stack.url, "httpOnly": True, "sameSite": "Strict"}])
        person.shows_scans()
        return person

    @staticmethod
    def signs_up_and_in(stack: TestStack, page: Page, name: str) -> Person:
        """Signs up, opens the mailed link and chooses a password, which signs in."""
        person = Person(stack, page, f"{name}-{secrets.token_hex(4)}@example.org")
        person.sign_up()
        page.goto(person.mailed_link())
        person.choose_password()
        person.shows_scans()
        return person

    def sign_up(self) -> None:
        # All tests come from one address, which may sign up fewer users per hour than the tests need.
        self.stack.psql("DELETE FROM attempts")
        self.page.goto(self.stack.url + "/sign-up")
        self.page.get_by_label("Email address").fill(self.email)
        self.page.get_by_label("I agree").check()
        self.page.get_by_role("button", name="Create account").click()
        expect(self.page.get_by_role("heading", name="Check your email")).to_be_visible()

    def choose_password(self) -> None:
        """Handles the page that the mailed link leads to."""
        self.page.get_by_label("Password", exact=True).fill(PASSWORD)
        self.page.get_by_role("button", name="Set password and sign in").click()
        expect(self.page.get_by_role("heading", name="Welcome")).to_be_visible()

    def mailed_link(self) -> str:
        mails = self.stack.wait_until(lambda: self.stack.mails(self.email), what="the mail")
        return LINK.search(mails[-1].get_content()).group(0)

    def sign_in(self, password: str = PASSWORD) -> None:
        self.page.get_by_label("Email address").fill(self.email)
        self.page.get_by_label("Password", exact=True).fill(password)
        self.page.get_by_role("button", name="Sign in").click()
        expect(self.page.get_by_role("heading", name="My scans")).to_be_visible()

    def becomes_administrator(self) -> None:
        """Makes the user an administrator with a second factor, effective from the next page."""
        self.stack.psql("UPDATE users SET is_administrator = true WHERE email = %s", self.email)
        made = self.page.evaluate(POST, ["/v1/me/second-factor", {"password": PASSWORD}])
        self.page.evaluate(POST, ["/v1/me/second-factor/confirm", {"code": pyotp.TOTP(made["secret"]).now()}])

    def choose_folder(self, folder: Path) -> None:
        self.page.goto(self.stack.url + "/add")
        self.page.get_by_label("Choose a folder").set_input_files(folder)

    def upload(self, folder: Path, title: str) -> None:
        self.choose_folder(folder)
        self.page.get_by_label("Your name for this scan").fill(title)
        self.page.get_by_role("button", name="Upload", exact=True).click()
        expect(self.page.get_by_role("heading", name="My scans")).to_be_visible()

    def card(self, title: str):
        return self.page.locator("article.card", has_text=title)

    def shows_scans(self) -> None:
        self.page.goto(self.stack.url + "/scans")
        expect(self.page.get_by_role("heading", name="My scans")).to_be_visible()

    def has_scan(self, folder: Path, title: str) -> str:
        """Is given the folder's scan as if it had been uploaded earlier. Returns its id."""
        scan = give_scan(self.stack, self.email, folder, title)
        self.shows_scans()
        expect(self.card(title)).to_have_attribute("data-state", "ready")
        return scan

    def uploads_scan(self, folder: Path, title: str) -> str:
        """Uploads the folder and waits until the scan is built. Returns its id."""
        self.upload(folder, title)
        expect(self.card(title)).to_have_attribute("data-state", "ready")
        return self.card(title).get_attribute("data-id")

    def open_scan(self, title: str) -> None:
        self.page.get_by_role("link", name=f"Open {title}").click()
        expect(self.page.locator("canvas[data-samples]")).to_be_visible()

    def api(self, method: str, path: str, body: object | None = None, headers: dict | None = None) -> int:
        """Returns the status of a request by this user's browser with the right CSRF token."""
        return self.page.evaluate(
            """async ([method, path, body, headers]) => {
                const me = await (await fetch("/v1/me")).json();
                const init = { method, headers: { "X-CSRF-Token": me.csrf_token, "Content-Type": "application/json", ...headers } };
                if (body !== null) init.body = JSON.stringify(body);
                return (await fetch(path, init)).status;
            }""", [method, path, body, headers or {}])
