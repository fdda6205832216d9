import { useState } from "preact/hooks";
import { t } from "../texts";
import { looksLikeEmail } from "./account";
import { AccountFrame } from "./account_frame";
import { EmailField } from "./field";
import { Form, fault, faultsOf, type Faults } from "./form";
import { useMailedToken } from "./mailed_link";
import { MailedPassword } from "./mailed_password";
import { Link } from "./router";
import { Notice } from "./shell";
import { useApp } from "./state";

/** Requests a link to reset a forgotten password. The page does not reveal whether the account exists. */
export function Forgot() {
  const app = useApp();
  const [email, setEmail] = useState("");
  const [faults, setFaults] = useState<Faults<"email">>({});
  const [busy, setBusy] = useState(false);
  const [sent, setSent] = useState(false);

  if (sent)
    return (
      <AccountFrame title={t.titles.checkMail}>
        <Notice kind="good">{t.account.forgotSent(email.trim())}</Notice>
        <p class="muted">{t.account.mailHint}</p>
        <p>
          <button type="button" class="button" onClick={() => setSent(false)}>
            {t.account.mailAgain}
          </button>
        </p>
        <p class="muted">
          <Link href="/sign-in">{t.account.toSignIn}</Link>
        </p>
      </AccountFrame>
    );
  const submit = async () => {
    if (!looksLikeEmail(email)) {
      setFaults({ email: email === "" ? t.account.required : t.account.emailWrong });
      return;
    }
    setBusy(true);
    try {
      await app.api.requestPasswordReset(email.trim());
      setSent(true);
    } catch (thrown) {
      setFaults(faultsOf(thrown, ["email"], (what) => app.explain(what)));
    } finally {
      setBusy(false);
    }
  };
  return (
    <AccountFrame title={t.titles.forgot} lead={t.account.forgotLead}>
      <Form onSubmit={submit} busy={busy} label={t.account.forgotSend} {...fault(faults.form)}>
        <EmailField autocomplete="username" value={email} onInput={setEmail} {...fault(faults.email)} />
      </Form>
      <p class="muted">
        <Link href="/sign-in">{t.account.toSignIn}</Link>
      </p>
    </AccountFrame>
  );
}

/** The page that the link in the password email opens. */
export function Reset({ token }: { readonly token: string }) {
  const app = useApp();
  return (
    <MailedPassword
      token={token}
      page="/reset"
      title={t.titles.reset}
      lead={t.account.resetLead}
      label={t.account.newPassword}
      button={t.account.reset}
      doneTitle={t.titles.resetDone}
      doneText={t.account.resetDone}
      next={{ href: "/sign-in", label: t.account.toSignIn }}
      redeem={async (mailed, password) => {
        await app.api.resetPassword(mailed, password);
        app.me.value = null;
      }}
    >
      <Link href="/forgot">{t.account.askAgain}</Link>
    </MailedPassword>
  );
}

/** The page that the link to a new address opens. */
export function ConfirmEmail({ token }: { readonly token: string }) {
  const app = useApp();
  const outcome = useMailedToken(token, "/confirm-email", async (mailed) => {
    await app.api.confirmEmail(mailed);
    void app.load();
    history.replaceState(null, "", "/account"); // a reload has no token to redeem again
    return t.account.emailChanged;
  });
  if (!outcome)
    return (
      <AccountFrame title={t.titles.confirmEmail}>
        <p class="muted" role="status">
          {t.account.confirmingEmail}
        </p>
      </AccountFrame>
    );
  return (
    <AccountFrame title={outcome.ok ? t.titles.confirmEmail : t.account.verifyFailed}>
      <Notice kind={outcome.ok ? "good" : "bad"}>{outcome.text}</Notice>
      <p>
        <Link href="/account" class="button button-main">
          {t.nav.account}
        </Link>
      </p>
    </AccountFrame>
  );
}
