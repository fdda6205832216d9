import type { ComponentChildren } from "preact";
import { useEffect, useState } from "preact/hooks";
import { t } from "../texts";
import { AccountFrame } from "./account_frame";
import { Form, fault, faultsOf, type Faults } from "./form";
import { NewPassword } from "./new_password";
import { Link } from "./router";
import { Notice } from "./shell";
import { useApp } from "./state";
import { shortestPassword } from "./strength";

interface PasswordFormProps {
  readonly token: string;
  /** The URL after the token has been removed. */
  readonly page: string;
  readonly label: string;
  readonly button: string;
  readonly redeem: (token: string, password: string) => Promise<void>;
}

export interface MailedPasswordProps extends PasswordFormProps {
  readonly title: string;
  readonly lead: string;
  readonly doneTitle: string;
  readonly doneText: string;
  /**
   * The page to which users go afterwards. A reload leads there as well, because it has no token to
   * redeem again.
   */
  readonly next: { readonly href: string; readonly label: string };
  /** The link below the form. */
  readonly children: ComponentChildren;
}

/** The page behind an emailed link for choosing a password. */
export function MailedPassword({ title, lead, doneTitle, doneText, next, children, ...form }: MailedPasswordProps) {
  const [done, setDone] = useState(false);
  if (done)
    return (
      <AccountFrame title={doneTitle}>
        <Notice kind="good">{doneText}</Notice>
        <p>
          <Link href={next.href} class="button button-main">
            {next.label}
          </Link>
        </p>
      </AccountFrame>
    );
  return (
    <AccountFrame title={title} lead={lead}>
      <PasswordForm
        {...form}
        onDone={() => {
          history.replaceState(null, "", next.href);
          setDone(true);
        }}
      />
      <p class="muted">{children}</p>
    </AccountFrame>
  );
}

function PasswordForm({
  token,
  page,
  label,
  button,
  redeem,
  onDone,
}: PasswordFormProps & { readonly onDone: () => void }) {
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
