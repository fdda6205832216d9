import { useEffect, useState } from "preact/hooks";

import { t } from "../texts";
import { useApp } from "./state";
import { useLatest } from "./use_latest";

/** What came of a link that was mailed: `text` in words for the person. */
export interface MailedOutcome {
  readonly ok: boolean;
  readonly text: string;
}

/**
 * Redeems the token of a mailed link once. `redeem` answers with the text to show, and the result is null until then.
 * The address is replaced by `page`.
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
    // The token is used up in a moment; it need not stay in the address and the history.
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
