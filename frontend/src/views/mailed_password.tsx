import { useEffect, useState } from "preact/hooks";
import { t } from "../texts";
import { Form, fault, faults_of, type Faults } from "./form";
import { NewPassword } from "./new_password";
import { Notice } from "./shell";
import { useApp } from "./state";
import { shortest_password } from "./strength";

export interface MailedPasswordProps {
  readonly token: string;
  /** What is left in the address. */
  readonly page: string;
  readonly label: string;
  readonly button: string;
  readonly use: (token: string, password: string) => Promise<void>;
  readonly onDone: () => void;
}

/** The form behind a mailed link by which a password is chosen. */
export function MailedPassword({ token, page, label, button, use, onDone }: MailedPasswordProps) {
  const app = useApp();
  const [kept] = useState(token);
  const [password, set_password] = useState("");
  const [faults, set_faults] = useState<Faults<"password">>({});
  const [busy, set_busy] = useState(false);
  useEffect(() => {
    // The token opens the account; it must not stay in the address and the history.
    history.replaceState(null, "", page);
  }, [page]);

  if (kept === "") return <Notice kind="bad">{t.account.verify_no_token}</Notice>;
  const submit = async () => {
    if (Array.from(password).length < shortest_password) {
      set_faults({ password: t.account.password_short });
      return;
    }
    set_faults({});
    set_busy(true);
    try {
      await use(kept, password);
      onDone();
    } catch (thrown) {
      set_faults(faults_of(thrown, ["password"], (what) => app.explain(what)));
      set_busy(false);
    }
  };
  return (
    <Form onSubmit={submit} busy={busy} label={button} {...fault(faults.form)}>
      <NewPassword label={label} value={password} onInput={set_password} {...fault(faults.password)} />
    </Form>
  );
}
