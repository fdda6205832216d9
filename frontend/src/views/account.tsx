import { useEffect, useRef, useState } from "preact/hooks";
import { ApiProblem } from "../api/client";
import type { Me } from "../api/types";
import { t } from "../texts";
import { AccountFrame } from "./account_frame";
import { CodeField } from "./code_field";
import { Field } from "./field";
import { Form, fault, faults_of, type Faults } from "./form";
import { MailedPassword } from "./mailed_password";
import { Link, navigate } from "./router";
import { Notice } from "./shell";
import { useApp, type AppState } from "./state";

export const looks_like_email = (text: string): boolean => /^[^\s@]+@[^\s@]+$/.test(text.trim());

type Credentials = "email" | "password";
const both: readonly Credentials[] = ["email", "password"];

/** An address alone: its password is chosen by whoever opens the mailed link. */
export function SignUp() {
  const app = useApp();
  const [email, set_email] = useState("");
  const [faults, set_faults] = useState<Faults<"email">>({});
  const [busy, set_busy] = useState(false);
  const [sent, set_sent] = useState(false);

  if (sent)
    return (
      <AccountFrame title={t.titles.check_mail}>
        <Notice kind="good">{t.account.mail_sent(email.trim())}</Notice>
        <p class="muted">{t.account.mail_hint}</p>
      </AccountFrame>
    );

  const submit = async () => {
    if (!looks_like_email(email)) {
      set_faults({ email: email === "" ? t.account.required : t.account.email_wrong });
      return;
    }
    set_faults({});
    set_busy(true);
    try {
      await app.api.sign_up(email.trim());
      set_sent(true);
    } catch (thrown) {
      set_faults(faults_of(thrown, ["email"], (what) => app.explain(what)));
    } finally {
      set_busy(false);
    }
  };
  return (
    <AccountFrame title={t.titles.sign_up} lead={t.account.sign_up_lead}>
      <Form onSubmit={submit} busy={busy} label={t.account.sign_up} {...fault(faults.form)}>
        <Field label={t.account.email} type="email" autocomplete="email" value={email} onInput={set_email} {...fault(faults.email)} />
      </Form>
      <p class="muted">{t.account.have_one} <Link href="/sign-in">{t.account.sign_in}</Link></p>
    </AccountFrame>
  );
}

export function SignIn() {
  const app = useApp();
  const [email, set_email] = useState("");
  const [password, set_password] = useState("");
  const [faults, set_faults] = useState<Faults<Credentials>>({});
  const [busy, set_busy] = useState(false);
  const [code_needed, set_code_needed] = useState(false);

  const submit = async () => {
    const found: Faults<Credentials> = {
      ...(email === "" ? { email: t.account.required } : {}),
      ...(password === "" ? { password: t.account.required } : {}),
    };
    set_faults(found);
    if (found.email !== undefined || found.password !== undefined) return;
    set_busy(true);
    try {
      enter(app, await app.api.sign_in(email.trim(), password));
    } catch (thrown) {
      if (thrown instanceof ApiProblem && thrown.kind === "code-needed") set_code_needed(true);
      else set_faults(faults_of(thrown, both, (what) => app.explain(what)));
      set_busy(false);
    }
  };
  if (code_needed) return <SignInCode email={email.trim()} password={password} onBack={() => set_code_needed(false)} />;
  return (
    <AccountFrame title={t.titles.sign_in} lead={t.account.sign_in_lead}>
      <Form onSubmit={submit} busy={busy} label={t.account.sign_in} {...fault(faults.form)}>
        <Field label={t.account.email} type="email" autocomplete="username" value={email} onInput={set_email} {...fault(faults.email)} />
        <Field label={t.account.password} type="password" autocomplete="current-password" value={password} onInput={set_password} {...fault(faults.password)} />
      </Form>
      <p class="muted"><Link href="/forgot">{t.account.forgot}</Link></p>
      <p class="muted">{t.account.have_none} <Link href="/sign-up">{t.account.sign_up}</Link></p>
    </AccountFrame>
  );
}

function enter(app: AppState, me: Me): void {
  if (location.pathname === "/sign-in" || location.pathname === "/sign-up") navigate("/scans", true);
  app.signed_in(me);
}

interface SignInCodeProps {
  readonly email: string;
  readonly password: string;
  readonly onBack: () => void;
}

/** The second step of an account that has a second factor. */
function SignInCode({ email, password, onBack }: SignInCodeProps) {
  const app = useApp();
  const [code, set_code] = useState("");
  const [recovery, set_recovery] = useState(false);
  const [faults, set_faults] = useState<Faults<"code">>({});
  const [busy, set_busy] = useState(false);
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => box.current?.querySelector("input")?.focus(), [recovery]);

  const submit = async () => {
    set_faults(code.trim() === "" ? { code: t.account.required } : {});
    if (code.trim() === "") return;
    set_busy(true);
    try {
      enter(app, await app.api.sign_in(email, password, code.trim()));
    } catch (thrown) {
      const wrong = thrown instanceof ApiProblem && thrown.kind === "wrong-code";
      set_faults(wrong ? { code: thrown.detail } : faults_of(thrown, ["code"], (what) => app.explain(what)));
      set_busy(false);
    }
  };
  const change = () => {
    set_recovery(!recovery);
    set_code("");
    set_faults({});
  };
  return (
    <AccountFrame title={t.titles.code} lead={t.second_factor.sign_in_lead}>
      <div ref={box}>
        <Form onSubmit={submit} busy={busy} label={t.account.sign_in} {...fault(faults.form)}>
          <CodeField value={code} onInput={set_code} recovery={recovery} {...fault(faults.code)} />
        </Form>
      </div>
      <p class="buttons">
        <button type="button" class="button button-small" onClick={change}>{recovery ? t.second_factor.use_device : t.second_factor.use_recovery}</button>
        <button type="button" class="button button-small" onClick={onBack}>{t.second_factor.back}</button>
      </p>
    </AccountFrame>
  );
}

/** Where the link of a sign-up's mail leads. */
export function Verify({ token }: { readonly token: string }) {
  const app = useApp();
  const [done, set_done] = useState(false);
  if (done)
    return (
      <AccountFrame title={t.account.verified_title}>
        <Notice kind="good">{t.account.verified}</Notice>
        <p><Link href="/sign-in" class="button button-main">{t.account.to_sign_in}</Link></p>
      </AccountFrame>
    );
  return (
    <AccountFrame title={t.titles.verify} lead={t.account.verify_lead}>
      <MailedPassword
        token={token}
        page="/verify"
        label={t.account.password}
        button={t.account.verify_submit}
        use={(mailed, password) => app.api.verify(mailed, password)}
        onDone={() => set_done(true)}
      />
      <p class="muted"><Link href="/sign-in">{t.account.to_sign_in}</Link></p>
    </AccountFrame>
  );
}
