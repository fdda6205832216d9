import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { is_open } from "../api/upload_view";
import { change_language, language, t } from "../texts";
import { languages, type Language } from "../texts/choose";
import { Icon, Mark } from "./icons";
import { Link, navigate, route } from "./router";
import { useApp } from "./state";
import { theme, toggle_theme } from "./theme";

export function ThemeSwitch() {
  const label = theme.value === "dark" ? t.theme.to_light : t.theme.to_dark;
  return (
    <button type="button" class="icon-button theme-switch" aria-label={label} title={label} onClick={toggle_theme}>
      <Icon name={theme.value === "dark" ? "sun" : "moon"} />
    </button>
  );
}

/** Each language by its own name, so that one finds one's own among any others. */
function LanguageChoice() {
  return (
    <label class="language">
      <span>{t.language}</span>
      <select class="choice" value={language.value} onChange={(event) => {
        const select = event.currentTarget;
        void change_language(select.value as Language).catch(() => (select.value = language.value));
      }}>
        {Object.entries(languages).map(([one, name]) => <option key={one} value={one} lang={one}>{name}</option>)}
      </select>
    </label>
  );
}

/** How far the uploads are, on whatever page one is. */
function UploadLine() {
  const open = [...useApp().uploads.views.value.values()].filter(is_open);
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
  const app = useApp();
  const me = app.me.value;
  return (
    <>
      <a class="skip" href="#content" onClick={(event) => {
        event.preventDefault();
        document.getElementById("content")?.focus();
      }}>{t.skip}</a>
      <header class="bar">
        <Link href="/" class="brand">
          <Mark />
          <span>{t.name}</span>
        </Link>
        {me ? (
          <nav class="bar-nav" aria-label={t.name}>
            <Link href="/scans" current={route.value.page === "scans"}>{t.nav.scans}</Link>
            <Link href="/add" current={route.value.page === "add"}>{t.nav.add}</Link>
            <Link href="/gallery" current={route.value.page === "gallery"}>{t.sharing.gallery.nav}</Link>
            {me.administrator ? <Link href="/admin" current={["admin", "reports"].includes(route.value.page)}>{t.nav.admin}</Link> : null}
          </nav>
        ) : (
          <nav class="bar-nav" aria-label={t.name}>
            <Link href="/gallery" current={route.value.page === "gallery"}>{t.sharing.gallery.nav}</Link>
          </nav>
        )}
        <div class="bar-end">
          {me ? <UploadLine /> : null}
          <ThemeSwitch />
          {me === null && !["sign_in", "sign_up"].includes(route.value.page) ? <Link href="/sign-in" class="button button-small">{t.account.sign_in}</Link> : null}
          {me ? (
            <>
              <Link href="/account" class="bar-account" label={`${t.nav.account}: ${me.email}`} current={route.value.page === "account"}>
                <Icon name="person" />
                <span class="bar-who">{me.email}</span>
              </Link>
              <button type="button" class="icon-button" aria-label={t.nav.sign_out} title={t.nav.sign_out} onClick={() => {
                void app.sign_out().catch(() => undefined).then(() => navigate("/sign-in"));
              }}>
                <Icon name="out" />
              </button>
            </>
          ) : null}
        </div>
      </header>
      <main id="content" tabIndex={-1}>{children}</main>
      <footer class="foot"><LanguageChoice /></footer>
    </>
  );
}

/** The heading of a page. Takes the focus when the page changes, so that a screen reader says where one is. */
export function PageTitle({ text, first }: { readonly text: string; readonly first?: boolean }) {
  const heading = useRef<HTMLHeadingElement>(null);
  useEffect(() => {
    document.title = `${text} · ${t.name}`;
    if (!first) heading.current?.focus({ preventScroll: true });
  }, [text, first]);
  return <h1 ref={heading} tabIndex={-1}>{text}</h1>;
}

/** Where the focus goes when what had it is no more. */
export function focus_title(): void {
  document.querySelector<HTMLElement>("h1")?.focus({ preventScroll: true });
}

/** A button that was pressed may go with what it changed: `what`. Who has only keys then goes on from the title, not from nowhere. */
export function use_focus_kept(what: unknown): void {
  useEffect(() => {
    if (document.activeElement === document.body) focus_title();
  }, [what]);
}

export function Notice({ kind, children }: { readonly kind: "bad" | "info" | "good"; readonly children: ComponentChildren }) {
  return (
    <p class={`notice notice-${kind}`} role={kind === "bad" ? "alert" : "status"}>
      <Icon name={kind === "bad" ? "alert" : kind === "good" ? "check" : "shield"} />
      <span>{children}</span>
    </p>
  );
}

export function Bar({ value, label }: { readonly value: number | null; readonly label: string }) {
  return value === null ? <progress aria-label={label} /> : <progress aria-label={label} max={1} value={value} />;
}
