"""What a person does with the pages. No more than a person could: by what is written on them."""

from __future__ import annotations

import re
import secrets
from dataclasses import dataclass
from pathlib import Path

import pyotp
from playwright.sync_api import Page, expect

from harness import TestStack

#: How long anything is waited for: states are, never times. On two cores that builds and other tests share, a part of an
#: upload or a picture takes many times as long as on free ones; a state that never comes is worth the wait.
PATIENCE_MS = 120_000
PASSWORD = "three blind mice run"
LINK = re.compile(r"http\S+/verify#token=[0-9a-f]{64}")

#: The answer to a request of this person's browser; an error unless it succeeds.
POST = """async ([path, body]) => {
    const me = await (await fetch("/v1/me")).json();
    const headers = { "X-CSRF-Token": me.csrf_token, "Content-Type": "application/json" };
    const answer = await fetch(path, { method: "POST", headers, body: JSON.stringify(body) });
    if (!answer.ok) throw new Error(`${path}: ${answer.status} ${await answer.text()}`);
    return answer.json();
}"""


@dataclass
class Person:
    """Somebody with an account, in front of a page."""

    stack: TestStack
    page: Page
    email: str

    @staticmethod
    def arrives(stack: TestStack, page: Page, name: str) -> Person:
        """Signs up, opens the mailed link, signs in."""
        person = Person(stack, page, f"{name}-{secrets.token_hex(4)}@example.org")
        person.sign_up()
        page.goto(person.mailed_link())
        person.choose_password()
        page.get_by_role("link", name="Go to sign-in").click()
        person.sign_in()
        return person

    def sign_up(self) -> None:
        # All tests come from one address, and more people sign up than one address may send within an hour.
        self.stack.psql("DELETE FROM attempts")
        self.page.goto(self.stack.url + "/sign-up")
        self.page.get_by_label("E-mail address").fill(self.email)
        self.page.get_by_role("button", name="Create account").click()
        expect(self.page.get_by_role("heading", name="Check your mail")).to_be_visible()

    def choose_password(self) -> None:
        """Where the mailed link leads."""
        self.page.get_by_label("Password", exact=True).fill(PASSWORD)
        self.page.get_by_role("button", name="Confirm address and set password").click()
        expect(self.page.get_by_role("heading", name="Welcome")).to_be_visible()

    def mailed_link(self) -> str:
        mails = self.stack.wait_until(lambda: self.stack.mails(self.email), what="the mail")
        return LINK.search(mails[-1].get_content()).group(0)

    def sign_in(self, password: str = PASSWORD) -> None:
        self.page.get_by_label("E-mail address").fill(self.email)
        self.page.get_by_label("Password", exact=True).fill(password)
        self.page.get_by_role("button", name="Sign in").click()
        expect(self.page.get_by_role("heading", name="My scans")).to_be_visible()

    def becomes_administrator(self) -> None:
        """One who may do all that administrators may, with a second factor, from the next look at a page on."""
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

    def has_scan(self, folder: Path, title: str) -> str:
        """Uploads it and waits until it is built; gives its id."""
        self.upload(folder, title)
        expect(self.card(title)).to_have_attribute("data-state", "ready")
        return self.card(title).get_attribute("data-id")

    def open_scan(self, title: str) -> None:
        self.page.get_by_role("link", name=f"Open {title}").click()
        expect(self.page.locator("canvas[data-samples]")).to_be_visible()

    def api(self, method: str, path: str, body: object | None = None, headers: dict | None = None) -> int:
        """The status that this person's browser gets, with the right CSRF token."""
        return self.page.evaluate(
            """async ([method, path, body, headers]) => {
                const me = await (await fetch("/v1/me")).json();
                const init = { method, headers: { "X-CSRF-Token": me.csrf_token, "Content-Type": "application/json", ...headers } };
                if (body !== null) init.body = JSON.stringify(body);
                return (await fetch(path, init)).status;
            }""", [method, path, body, headers or {}])
