import { useEffect, useState } from "preact/hooks";
import { ApiProblem } from "../api/client";
import { t } from "../texts/en";
import { AccountFrame } from "./account_frame";
import { Field } from "./field";
import { Link, navigate } from "./router";
import { Notice } from "./shell";
import { useApp } from "./state";

const looks_like_email = (text: string): boolean => /^[^\s@]+@[^\s@]+$/.test(text.trim());
const shortest_password = 10;

interface Faults {
  readonly email?: string;
  readonly password?: string;
  readonly form?: string;
}

function faults_of(thrown: unknown, explain: (thrown: unknown) => string): Faults {
  if (thrown instanceof ApiProblem) {
    const of = (field: string) => thrown.errors.find((error) => error.field === field)?.message;
    const email = of("email");
    const password = of("password");
    if (email !== undefined || password !== undefined)
      return { ...(email === undefined ? {} : { email }), ...(password === undefined ? {} : { password }) };
  }
  return { form: explain(thrown) };
}

export function SignUp() {
  const app = useApp();
  const [email, set_email] = useState("");
  const [password, set_password] = useState("");
  const [faults, set_faults] = useState<Faults>({});
  const [busy, set_busy] = useState(false);
  const [sent, set_sent] = useState(false);

  if (sent)
    return (
      <AccountFrame title={t.titles.check_mail}>
        <Notice kind="good">{t.account.mail_sent(email.trim())}</Notice>
        <p class="muted">{t.account.mail_hint}</p>
        <p><Link href="/sign-in" class="button">{t.account.to_sign_in}</Link></p>
      </AccountFrame>
    );

  const submit = async () => {
    const found: Faults = {
      ...(looks_like_email(email) ? {} : { email: email === "" ? t.account.required : t.account.email_wrong }),
      ...(Array.from(password).length >= shortest_password ? {} : { password: t.account.password_short }),
    };
    set_faults(found);
    if (found.email !== undefined || found.password !== undefined) return;
    set_busy(true);
    try {
      await app.api.sign_up(email.trim(), password);
      set_sent(true);
    } catch (thrown) {
      set_faults(faults_of(thrown, (what) => app.explain(what)));
    } finally {
      set_busy(false);
    }
  };
  return (
    <AccountFrame title={t.titles.sign_up} lead={t.account.sign_up_lead}>
      <Form onSubmit={submit} busy={busy} label={t.account.sign_up} {...(faults.form ? { fault: faults.form } : {})}>
        <Field label={t.account.email} type="email" autocomplete="email" value={email} onInput={set_email} {...(faults.email ? { fault: faults.email } : {})} />
        <Field label={t.account.password} type="password" autocomplete="new-password" value={password} onInput={set_password} hint={t.account.password_hint} {...(faults.password ? { fault: faults.password } : {})} />
      </Form>
      <p class="muted">{t.account.have_one} <Link href="/sign-in">{t.account.sign_in}</Link></p>
    </AccountFrame>
  );
}

export function SignIn() {
  const app = useApp();
  const [email, set_email] = useState("");
  const [password, set_password] = useState("");
  const [faults, set_faults] = useState<Faults>({});
  const [busy, set_busy] = useState(false);

  const submit = async () => {
    const found: Faults = {
      ...(email === "" ? { email: t.account.required } : {}),
      ...(password === "" ? { password: t.account.required } : {}),
    };
    set_faults(found);
    if (found.email !== undefined || found.password !== undefined) return;
    set_busy(true);
    try {
      const me = await app.api.sign_in(email.trim(), password);
      if (location.pathname === "/sign-in" || location.pathname === "/sign-up") navigate("/scans", true);
      app.signed_in(me);
    } catch (thrown) {
      set_faults(faults_of(thrown, (what) => app.explain(what)));
      set_busy(false);
    }
  };
  return (
    <AccountFrame title={t.titles.sign_in} lead={t.account.sign_in_lead}>
      <Form onSubmit={submit} busy={busy} label={t.account.sign_in} {...(faults.form ? { fault: faults.form } : {})}>
        <Field label={t.account.email} type="email" autocomplete="username" value={email} onInput={set_email} {...(faults.email ? { fault: faults.email } : {})} />
        <Field label={t.account.password} type="password" autocomplete="current-password" value={password} onInput={set_password} {...(faults.password ? { fault: faults.password } : {})} />
      </Form>
      <p class="muted">{t.account.have_none} <Link href="/sign-up">{t.account.sign_up}</Link></p>
    </AccountFrame>
  );
}

export function Verify({ token }: { readonly token: string }) {
  const app = useApp();
  const [outcome, set_outcome] = useState<{ ok: boolean; text: string } | null>(null);
  useEffect(() => {
    // The token is used up in a moment; it need not stay in the address and the history.
    history.replaceState(null, "", "/verify");
    if (token === "") {
      set_outcome({ ok: false, text: t.account.verify_no_token });
      return;
    }
    app.api.verify(token).then(
      () => set_outcome({ ok: true, text: t.account.verified }),
      (thrown: unknown) => set_outcome({ ok: false, text: app.explain(thrown) }),
    );
  }, [app, token]);

  if (!outcome)
    return <AccountFrame title={t.titles.verify}><p class="muted" role="status">{t.account.verifying}</p></AccountFrame>;
  return (
    <AccountFrame title={outcome.ok ? t.account.verified_title : t.account.verify_failed}>
      <Notice kind={outcome.ok ? "good" : "bad"}>{outcome.text}</Notice>
      <p><Link href="/sign-in" class="button button-main">{t.account.to_sign_in}</Link></p>
    </AccountFrame>
  );
}

interface FormProps {
  readonly onSubmit: () => Promise<void>;
  readonly busy: boolean;
  readonly label: string;
  readonly fault?: string;
  readonly children: preact.ComponentChildren;
}

function Form({ onSubmit, busy, label, fault, children }: FormProps) {
  return (
    <form
      noValidate
      onSubmit={(event) => {
        event.preventDefault();
        const form = event.currentTarget;
        void onSubmit().then(() => {
          // Once the faults are on the page: to the first of them.
          requestAnimationFrame(() => form.querySelector<HTMLElement>("[aria-invalid]")?.focus());
        });
      }}
    >
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
      {children}
      <button type="submit" class="button button-main button-wide" disabled={busy} aria-busy={busy}>{label}</button>
    </form>
  );
}
