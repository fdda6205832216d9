import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import type { Me } from "../api/types";
import { isOpen } from "../api/upload_view";
import { changeLanguage, language, t } from "../texts";
import { languages, type Language } from "../texts/choose";
import { IconButton } from "./icon_button";
import { Icon, Mark } from "./icons";
import { LegalLinks } from "./legal_links";
import { Link, navigate, route } from "./router";
import { useApp } from "./state";
import { theme, toggleTheme } from "./theme";

export function ThemeSwitch() {
  const label = theme.value === "dark" ? t.theme.toLight : t.theme.toDark;
  return (
    <button type="button" class="icon-button theme-switch" aria-label={label} title={label} onClick={toggleTheme}>
      <Icon name={theme.value === "dark" ? "sun" : "moon"} />
    </button>
  );
}

/**
 * The choice of the language. Each is listed under its native name, so that people find theirs in
 * any language.
 */
export function LanguageChoice() {
  return (
    <label class="language">
      <span>{t.language}</span>
      <select
        class="choice"
        value={language.value}
        onChange={(event) => {
          const select = event.currentTarget;
          void changeLanguage(select.value as Language).catch(() => (select.value = language.value));
        }}
      >
        {Object.entries(languages).map(([one, name]) => (
          <option key={one} value={one} lang={one}>
            {name}
          </option>
        ))}
      </select>
    </label>
  );
}

/** The progress of the uploads, which every page shows. */
function UploadLine() {
  const open = [...useApp().uploads.views.value.values()].filter(isOpen);
  if (open.length === 0) return null;
  const [sent, total] = open.reduce(([s, a], view) => [s + view.sent, a + view.total], [0, 0]);
  return (
    <Link href="/scans" class="bar-upload">
      <progress max={total} value={sent} aria-hidden="true" />
      <span>{t.scans.upload.all(open.length, Math.floor((100 * sent) / Math.max(1, total)))}</span>
    </Link>
  );
}

/** The frame of every page but the viewer. */
export function Shell({ children }: { readonly children: ComponentChildren }) {
  const me = useApp().me.value;
  return (
    <>
      <SkipLink />
      <header class="bar">
        <Link href="/" class="brand">
          <Mark />
          <span>{t.name}</span>
        </Link>
        <BarNav me={me} />
        <div class="bar-end">
          {me ? <UploadLine /> : null}
          <ThemeSwitch />
          {me === null && !["sign_in", "sign_up"].includes(route.value.page) ? (
            <Link href="/sign-in" class="button button-small">
              {t.account.signIn}
            </Link>
          ) : null}
          {me ? <AccountButtons me={me} /> : null}
        </div>
      </header>
      <main id="content" tabIndex={-1}>
        {children}
      </main>
      <footer class="foot">
        <LegalLinks />
        <LanguageChoice />
      </footer>
    </>
  );
}

/** A link that skips the navigation, for keyboard users. */
export function SkipLink() {
  return (
    <a
      class="skip"
      href="#content"
      onClick={(event) => {
        event.preventDefault();
        document.getElementById("content")?.focus();
      }}
    >
      {t.skip}
    </a>
  );
}

/** The main pages. Without an account there is only the gallery. */
function BarNav({ me }: { readonly me: Me | null | undefined }) {
  const { page } = route.value;
  return (
    <nav class="bar-nav" aria-label={t.name}>
      {me ? (
        <>
          <Link href="/scans" current={page === "scans"}>
            {t.nav.scans}
          </Link>
          <Link href="/add" current={page === "add"}>
            {t.nav.add}
          </Link>
        </>
      ) : null}
      <Link href="/gallery" current={page === "gallery"}>
        {t.sharing.gallery.nav}
      </Link>
      {me?.researcher ? (
        <Link href="/studies" current={["studies", "study"].includes(page)}>
          {t.studies.nav}
        </Link>
      ) : null}
      {me?.administrator ? (
        <Link href="/admin" current={["admin", "reports"].includes(page)}>
          {t.nav.admin}
        </Link>
      ) : null}
    </nav>
  );
}

function AccountButtons({ me }: { readonly me: Me }) {
  const app = useApp();
  const signOut = () => {
    void app
      .signOut()
      .catch(() => undefined)
      .then(() => navigate("/sign-in"));
  };
  return (
    <>
      <Link
        href="/account"
        class="bar-account"
        label={`${t.nav.account}: ${me.email}`}
        current={route.value.page === "account"}
      >
        <Icon name="person" />
        <span class="bar-who">{me.email}</span>
      </Link>
      <IconButton icon="out" label={t.nav.signOut} onClick={signOut} />
    </>
  );
}

/** The heading of a page. It takes the focus when the page changes, so that a screen reader announces the page. */
export function PageTitle({ text, first }: { readonly text: string; readonly first?: boolean }) {
  const heading = useRef<HTMLHeadingElement>(null);
  useEffect(() => {
    document.title = text.includes(t.name) ? text : `${text} · ${t.name}`;
    if (!first) heading.current?.focus({ preventScroll: true });
  }, [text, first]);
  return (
    <h1 ref={heading} tabIndex={-1}>
      {text}
    </h1>
  );
}

/** Moves the focus to the heading when the focused element has disappeared. */
export function focusTitle(): void {
  document.querySelector<HTMLElement>("h1")?.focus({ preventScroll: true });
}

/**
 * Moves the focus to the heading when a change of `what` has removed the pressed button, so that keyboard users
 * continue there.
 */
export function useFocusKept(what: unknown): void {
  useEffect(() => {
    if (document.activeElement === document.body) focusTitle();
  }, [what]);
}

export function Notice({
  kind,
  children,
}: {
  readonly kind: "bad" | "warn" | "info" | "good";
  readonly children: ComponentChildren;
}) {
  return (
    <p class={`notice notice-${kind}`} role={kind === "bad" ? "alert" : "status"}>
      <Icon name={kind === "bad" || kind === "warn" ? "alert" : kind === "good" ? "check" : "shield"} />
      <span>{children}</span>
    </p>
  );
}

export function Bar({ value, label }: { readonly value: number | null; readonly label: string }) {
  return value === null ? <progress aria-label={label} /> : <progress aria-label={label} max={1} value={value} />;
}
