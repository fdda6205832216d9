import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { t } from "../texts/en";
import { Icon, Mark } from "./icons";
import { Link, navigate, route } from "./router";
import { useApp } from "./state";
import { theme, toggle_theme } from "./theme";

export function ThemeSwitch() {
  const label = theme.value === "dark" ? t.theme.to_light : t.theme.to_dark;
  return (
    <button type="button" class="icon-button" aria-label={label} title={label} onClick={toggle_theme}>
      <Icon name={theme.value === "dark" ? "sun" : "moon"} />
    </button>
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
          </nav>
        ) : null}
        <div class="bar-end">
          <ThemeSwitch />
          {me ? (
            <>
              <span class="bar-who" title={t.nav.signed_in_as(me.email)}>{me.email}</span>
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
