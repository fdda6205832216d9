import { useEffect, useState } from "preact/hooks";

import { t } from "../texts";
import { useApp } from "./state";
import { useLatest } from "./use_latest";

/** The result of opening an emailed link. `text` is a message for the user. */
export interface MailedOutcome {
  readonly ok: boolean;
  readonly text: string;
}

/**
 * Redeems the token of an emailed link once. `redeem` returns the text to show, and the result is null until then. The
 * URL is replaced by `page`.
 */
export function useMailedToken(
  token: string,
  page: string,
  redeem: (token: string) => Promise<string>,
): MailedOutcome | null {
  const app = useApp();
  const [outcome, setOutcome] = useState<MailedOutcome | null>(null);
  const latestRedeem = useLatest(redeem); // it differs with each render, but the token must be used only once
  useEffect(() => {
    // The token is about to be used up and should not stay in the URL and the history.
    history.replaceState(null, "", page);
    if (token === "") {
      setOutcome({ ok: false, text: t.account.verifyNoToken });
      return;
    }
    latestRedeem.current(token).then(
      (text) => setOutcome({ ok: true, text }),
      (thrown: unknown) => setOutcome({ ok: false, text: app.explain(thrown) }),
    );
  }, [app, token, page, latestRedeem]);
  return outcome;
}
