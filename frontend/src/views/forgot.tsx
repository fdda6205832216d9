import { useState } from "preact/hooks";
import { t } from "../texts";
import { looks_like_email } from "./account";
import { AccountFrame } from "./account_frame";
import { Field } from "./field";
import { Form, fault, faults_of, type Faults } from "./form";
import { useMailedToken } from "./mailed_link";
import { MailedPassword } from "./mailed_password";
import { Link } from "./router";
import { Notice } from "./shell";
import { useApp } from "./state";

/** A forgotten password: a link is mailed, whoever has an account. */
export function Forgot() {
  const app = useApp();
  const [email, set_email] = useState("");
  const [faults, set_faults] = useState<Faults<"email">>({});
  const [busy, set_busy] = useState(false);
  const [sent, set_sent] = useState(false);

  if (sent)
    return (
      <AccountFrame title={t.titles.check_mail}>
        <Notice kind="good">{t.account.forgot_sent(email.trim())}</Notice>
        <p class="muted">{t.account.mail_hint}</p>
        <p><Link href="/sign-in" class="button">{t.account.to_sign_in}</Link></p>
      </AccountFrame>
    );
  const submit = async () => {
    if (!looks_like_email(email)) {
      set_faults({ email: email === "" ? t.account.required : t.account.email_wrong });
      return;
    }
    set_busy(true);
    try {
      await app.api.request_password_reset(email.trim());
      set_sent(true);
    } catch (thrown) {
      set_faults(faults_of(thrown, ["email"], (what) => app.explain(what)));
    } finally {
      set_busy(false);
    }
  };
  return (
    <AccountFrame title={t.titles.forgot} lead={t.account.forgot_lead}>
      <Form onSubmit={submit} busy={busy} label={t.account.forgot_send} {...fault(faults.form)}>
        <Field label={t.account.email} type="email" autocomplete="username" value={email} onInput={set_email} {...fault(faults.email)} />
      </Form>
      <p class="muted"><Link href="/sign-in">{t.account.to_sign_in}</Link></p>
    </AccountFrame>
  );
}

/** Where the link of that mail leads. */
export function Reset({ token }: { readonly token: string }) {
  const app = useApp();
  const [done, set_done] = useState(false);
  if (done)
    return (
      <AccountFrame title={t.titles.reset}>
        <Notice kind="good">{t.account.reset_done}</Notice>
        <p><Link href="/sign-in" class="button button-main">{t.account.to_sign_in}</Link></p>
      </AccountFrame>
    );
  return (
    <AccountFrame title={t.titles.reset} lead={t.account.reset_lead}>
      <MailedPassword
        token={token}
        page="/reset"
        label={t.account.new_password}
        button={t.account.reset}
        use={(mailed, password) => app.api.reset_password(mailed, password)}
        onDone={() => {
          app.me.value = null;
          set_done(true);
        }}
      />
      <p class="muted"><Link href="/forgot">{t.account.ask_again}</Link></p>
    </AccountFrame>
  );
}

/** Where the link mailed to a new address leads. */
export function ConfirmEmail({ token }: { readonly token: string }) {
  const app = useApp();
  const outcome = useMailedToken(token, "/confirm-email", async (mailed) => {
    await app.api.confirm_email(mailed);
    void app.load();
    return t.account.email_changed;
  });
  if (!outcome)
    return <AccountFrame title={t.titles.confirm_email}><p class="muted" role="status">{t.account.confirming_email}</p></AccountFrame>;
  return (
    <AccountFrame title={outcome.ok ? t.titles.confirm_email : t.account.verify_failed}>
      <Notice kind={outcome.ok ? "good" : "bad"}>{outcome.text}</Notice>
      <p><Link href="/account" class="button button-main">{t.nav.account}</Link></p>
    </AccountFrame>
  );
}
