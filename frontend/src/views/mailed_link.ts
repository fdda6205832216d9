import { useEffect, useState } from "preact/hooks";

import { t } from "../texts";
import { useApp } from "./state";

/** What came of a link that was mailed: `text` in words for the person. */
export interface MailedOutcome {
  readonly ok: boolean;
  readonly text: string;
}

/** Uses the token of a mailed link once, by `use`, which answers with what to say; null until then. `page` is left in the address. */
export function useMailedToken(token: string, page: string, use: (token: string) => Promise<string>): MailedOutcome | null {
  const app = useApp();
  const [outcome, set_outcome] = useState<MailedOutcome | null>(null);
  useEffect(() => {
    // The token is used up in a moment; it need not stay in the address and the history.
    history.replaceState(null, "", page);
    if (token === "") {
      set_outcome({ ok: false, text: t.account.verify_no_token });
      return;
    }
    use(token).then(
      (text) => set_outcome({ ok: true, text }),
      (thrown: unknown) => set_outcome({ ok: false, text: app.explain(thrown) }),
    );
    // `use` is made anew by each drawing of the page; the token must be used once.
  }, [app, token]);
  return outcome;
}
