import { useEffect, useRef, useState } from "preact/hooks";
import { ApiProblem } from "../api/client";
import type { Me } from "../api/types";
import { t } from "../texts";
import { problemText } from "../texts/problem_text";
import { AccountFrame } from "./account_frame";
import { CodeField } from "./code_field";
import { ConsentBox } from "./consent";
import { CurrentPassword, EmailField } from "./field";
import { Form, fault, faultsOf, type Faults } from "./form";
import { MailedPassword } from "./mailed_password";
import { Link, navigate } from "./router";
import { Notice } from "./shell";
import { useApp, type AppState } from "./state";

export const looksLikeEmail = (text: string): boolean => /^[^\s@]+@[^\s@]+$/.test(text.trim());

type Credentials = "email" | "password";
const both: readonly Credentials[] = ["email", "password"];

/**
 * The sign-up form, which asks only for the address. The password is chosen after opening the
 * emailed link.
 */
export function SignUp() {
  const app = useApp();
  const [email, setEmail] = useState("");
  const [consents, setConsents] = useState(false);
  const [faults, setFaults] = useState<Faults<"email" | "consent">>({});
  const [busy, setBusy] = useState(false);
  const [sent, setSent] = useState(false);

  if (sent)
    return (
      <AccountFrame title={t.titles.checkMail}>
        <Notice kind="good">{t.account.mailSent(email.trim())}</Notice>
        <p class="muted">{t.account.mailHint}</p>
        <p>
          <button type="button" class="button" onClick={() => setSent(false)}>
            {t.account.mailAgain}
          </button>
        </p>
      </AccountFrame>
    );

  const submit = async () => {
    const found: Faults<"email" | "consent"> = {
      ...(looksLikeEmail(email) ? {} : { email: email === "" ? t.account.required : t.account.emailWrong }),
      ...(consents ? {} : { consent: t.consent.missing }),
    };
    setFaults(found);
    if (found.email !== undefined || found.consent !== undefined) return;
    setBusy(true);
    try {
      await app.api.signUp(email.trim());
      setSent(true);
    } catch (thrown) {
      setFaults(faultsOf(thrown, ["email"], (what) => app.explain(what)));
    } finally {
      setBusy(false);
    }
  };
  return (
    <AccountFrame title={t.titles.signUp} lead={t.account.signUpLead}>
      <Form onSubmit={submit} busy={busy} label={t.account.signUp} {...fault(faults.form)}>
        <EmailField autocomplete="email" value={email} onInput={setEmail} {...fault(faults.email)} />
        <ConsentBox given={consents} onChange={setConsents} {...fault(faults.consent)} />
      </Form>
      <p class="muted">
        {t.account.haveOne} <Link href="/sign-in">{t.account.signIn}</Link>
      </p>
    </AccountFrame>
  );
}

export function SignIn() {
  const app = useApp();
  const [email, setEmail] = useState("");
  const [password, setPassword] = useState("");
  const [faults, setFaults] = useState<Faults<Credentials>>({});
  const [busy, setBusy] = useState(false);
  const [codeNeeded, setCodeNeeded] = useState(false);

  const submit = async () => {
    const found: Faults<Credentials> = {
      ...(email === "" ? { email: t.account.required } : {}),
      ...(password === "" ? { password: t.account.required } : {}),
    };
    setFaults(found);
    if (found.email !== undefined || found.password !== undefined) return;
    setBusy(true);
    try {
      enter(app, await app.api.signIn(email.trim(), password));
    } catch (thrown) {
      if (thrown instanceof ApiProblem && thrown.kind === "code-needed") setCodeNeeded(true);
      else setFaults(faultsOf(thrown, both, (what) => app.explain(what)));
      setBusy(false);
    }
  };
  if (codeNeeded) return <SignInCode email={email.trim()} password={password} onBack={() => setCodeNeeded(false)} />;
  return (
    <AccountFrame title={t.titles.signIn} lead={t.account.signInLead}>
      <Form onSubmit={submit} busy={busy} label={t.account.signIn} {...fault(faults.form)}>
        <EmailField autocomplete="username" value={email} onInput={setEmail} {...fault(faults.email)} />
        <CurrentPassword
          label={t.account.password}
          value={password}
          onInput={setPassword}
          {...fault(faults.password)}
        />
      </Form>
      <p class="muted">
        <Link href="/forgot">{t.account.forgot}</Link>
      </p>
      <p class="muted">
        {t.account.haveNone} <Link href="/sign-up">{t.account.signUp}</Link>
      </p>
      <p class="muted">
        <Link href="/gallery">{t.account.samples}</Link>
      </p>
    </AccountFrame>
  );
}

function enter(app: AppState, me: Me): void {
  if (location.pathname === "/sign-in" || location.pathname === "/sign-up") navigate("/scans", true);
  app.signedIn(me);
}

interface SignInCodeProps {
  readonly email: string;
  readonly password: string;
  readonly onBack: () => void;
}

/** The second step of signing in to an account with two-factor authentication. */
function SignInCode({ email, password, onBack }: SignInCodeProps) {
  const app = useApp();
  const [code, setCode] = useState("");
  const [recovery, setRecovery] = useState(false);
  const [faults, setFaults] = useState<Faults<"code">>({});
  const [busy, setBusy] = useState(false);
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => box.current?.querySelector("input")?.focus(), [recovery]);

  const submit = async () => {
    setFaults(code.trim() === "" ? { code: t.account.required } : {});
    if (code.trim() === "") return;
    setBusy(true);
    try {
      enter(app, await app.api.signIn(email, password, code.trim()));
    } catch (thrown) {
      const wrong = thrown instanceof ApiProblem && thrown.kind === "wrong-code";
      setFaults(wrong ? { code: problemText(thrown) } : faultsOf(thrown, ["code"], (what) => app.explain(what)));
      setBusy(false);
    }
  };
  const change = () => {
    setRecovery(!recovery);
    setCode("");
    setFaults({});
  };
  return (
    <AccountFrame title={t.titles.code} lead={t.secondFactor.signInLead}>
      <div ref={box}>
        <Form onSubmit={submit} busy={busy} label={t.account.signIn} {...fault(faults.form)}>
          <CodeField value={code} onInput={setCode} recovery={recovery} {...fault(faults.code)} />
        </Form>
      </div>
      <p class="buttons">
        <button type="button" class="button button-small" onClick={change}>
          {recovery ? t.secondFactor.useDevice : t.secondFactor.useRecovery}
        </button>
        <button type="button" class="button button-small" onClick={onBack}>
          {t.secondFactor.back}
        </button>
      </p>
    </AccountFrame>
  );
}

/** The page that the link in the confirmation email opens. */
export function Verify({ token }: { readonly token: string }) {
  const app = useApp();
  return (
    <MailedPassword
      token={token}
      page="/verify"
      title={t.titles.verify}
      lead={t.account.verifyLead}
      label={t.account.password}
      button={t.account.verifySubmit}
      doneTitle={t.account.verifiedTitle}
      doneText={t.account.verified(app.me.value?.email ?? "")}
      next={{ href: "/add", label: t.scans.add }}
      redeem={async (mailed, password) => app.signedIn(await app.api.verify(mailed, password))}
    >
      <Link href="/sign-in">{t.account.toSignIn}</Link>
    </MailedPassword>
  );
}
