import { useEffect, useState } from "preact/hooks";
import { t } from "../texts";
import { Form, fault, faultsOf, type Faults } from "./form";
import { NewPassword } from "./new_password";
import { Notice } from "./shell";
import { useApp } from "./state";
import { shortestPassword } from "./strength";

export interface MailedPasswordProps {
  readonly token: string;
  /** The URL after the token has been removed. */
  readonly page: string;
  readonly label: string;
  readonly button: string;
  readonly redeem: (token: string, password: string) => Promise<void>;
  readonly onDone: () => void;
}

/** The form behind an emailed link for choosing a password. */
export function MailedPassword({ token, page, label, button, redeem, onDone }: MailedPasswordProps) {
  const app = useApp();
  const [kept] = useState(token);
  const [password, setPassword] = useState("");
  const [faults, setFaults] = useState<Faults<"password">>({});
  const [busy, setBusy] = useState(false);
  useEffect(() => {
    // The token opens the account, so it must not stay in the URL and the history.
    history.replaceState(null, "", page);
  }, [page]);

  if (kept === "") return <Notice kind="bad">{t.account.verifyNoToken}</Notice>;
  const submit = async () => {
    if (Array.from(password).length < shortestPassword) {
      setFaults({ password: t.account.passwordShort });
      return;
    }
    setFaults({});
    setBusy(true);
    try {
      await redeem(kept, password);
      onDone();
    } catch (thrown) {
      setFaults(faultsOf(thrown, ["password"], (what) => app.explain(what)));
      setBusy(false);
    }
  };
  return (
    <Form onSubmit={submit} busy={busy} label={button} {...fault(faults.form)}>
      <NewPassword label={label} value={password} onInput={setPassword} {...fault(faults.password)} />
    </Form>
  );
}
