import { t } from "../../texts";
import { cameFrom, Link } from "../router";
import { useApp } from "../state";
import { OverPanel } from "./over_panel";

/**
 * A person who views a scan without using an account: a sample, a scan shared by link, or another
 * person's session.
 */
export interface Visitor {
  /** The kind of visit, which determines the explanation when it ends. */
  readonly kind: "sample" | "link" | "session";
  /** Begins another visit, if possible. */
  readonly again?: () => void;
}

/** Returns the target of the back link at the top. */
const returnPath = (visitor: Visitor): string => (visitor.kind === "sample" ? "/gallery" : "/");

export interface WayBack {
  readonly href: string;
  readonly text: string;
}

/** Returns the way from the viewer to the list that led here, or to one's own scans. */
export function wayBack(visitor: Visitor | undefined): WayBack {
  if (visitor) return { href: returnPath(visitor), text: t.viewer.visitor.back };
  const from = cameFrom();
  if (from === "/gallery") return { href: from, text: t.sharing.gallery.nav };
  if (from === "/reports") return { href: from, text: t.sharing.reports.title };
  return { href: "/scans", text: t.viewer.back };
}

/** Invites a visitor who has no account. */
export function Invitation() {
  if (useApp().me.value !== null) return null;
  return (
    <Link href="/sign-up" class="button button-small invitation">
      {t.viewer.visitor.invite}
    </Link>
  );
}

/** Replaces the picture when a visitor's time is over, and explains what happened and how to continue. */
export function VisitOver({ visitor }: { readonly visitor: Visitor }) {
  const known = useApp().me.value !== null;
  const text = t.viewer.visitor;
  return (
    <OverPanel
      heading={text.over}
      text={
        <>
          <p data-said>{text.overText[visitor.kind]}</p>
          {known ? null : (
            <p class="muted" data-said>
              {text.inviteText}
            </p>
          )}
        </>
      }
    >
      {visitor.again ? (
        <button type="button" class="button button-main" onClick={visitor.again}>
          {text.again}
        </button>
      ) : null}
      {known ? null : (
        <Link href="/sign-up" class={`button${visitor.again ? "" : " button-main"}`}>
          {t.account.signUp}
        </Link>
      )}
      <Link href={returnPath(visitor)} class="button">
        {visitor.kind === "sample" ? text.toSamples : t.toStart}
      </Link>
    </OverPanel>
  );
}
