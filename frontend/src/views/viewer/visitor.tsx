import { t } from "../../texts";
import { Link } from "../router";
import { useApp } from "../state";
import { OverPanel } from "./over_panel";

/** Somebody who looks without opening the scan with an account: at a sample, by a link, or in another person's session. */
export interface Visitor {
  /** What is looked at, which decides how its end is explained. */
  readonly kind: "sample" | "link" | "session";
  /** Begins another visit, where that is possible. */
  readonly again?: () => void;
}

/** Where the arrow at the top leads. */
export const wayBack = (visitor: Visitor): string => (visitor.kind === "sample" ? "/gallery" : "/");

/** Invites a visitor who has no account. */
export function Invitation() {
  if (useApp().me.value !== null) return null;
  return (
    <Link href="/sign-up" class="button button-small invitation">
      {t.viewer.visitor.invite}
    </Link>
  );
}

/** In place of a picture, when the time of a visitor is over: what happened, and what to press. */
export function VisitOver({ visitor }: { readonly visitor: Visitor }) {
  const known = useApp().me.value !== null;
  const text = t.viewer.visitor;
  return (
    <OverPanel
      heading={text.over}
      text={
        <>
          <p>{text.overText[visitor.kind]}</p>
          {known ? null : <p class="muted">{text.inviteText}</p>}
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
      <Link href={wayBack(visitor)} class="button">
        {visitor.kind === "sample" ? text.toSamples : t.toStart}
      </Link>
    </OverPanel>
  );
}
