import { useEffect, useRef, useState } from "preact/hooks";
import type { NewSecret, SecondFactor as State } from "../api/second_factor";
import { t } from "../texts";
import { CodeField } from "./code_field";
import { CancelButton, Dialog } from "./dialog";
import { CurrentPassword } from "./field";
import { Form, fault, faultsOf, type Faults } from "./form";
import { dayText } from "./format";
import { Icon } from "./icons";
import { Loading } from "./loading";
import { QrCode } from "./qr_code";
import { Link } from "./router";
import { Notice, PageTitle, useFocusKept } from "./shell";
import { useApp } from "./state";

type Given = "password" | "code";
const given: readonly Given[] = ["password", "code"];

const panelId = "second-factor";

/** Scrolls to the panel and focuses its heading if the URL points to it. */
function usePanelReached(ready: boolean) {
  const heading = useRef<HTMLHeadingElement>(null);
  useEffect(() => {
    if (ready && location.hash === `#${panelId}`) heading.current?.focus();
  }, [ready]);
  return heading;
}

/** The panel of the account page that sets up, renews or turns off two-factor authentication. */
export function SecondFactor() {
  const app = useApp();
  const [state, setState] = useState<State | null>(null);
  const [wrong, setWrong] = useState("");
  const [codes, setCodes] = useState<readonly string[] | null>(null);
  const [asking, setAsking] = useState<"renew" | "remove" | null>(null);
  const load = () => {
    app.api.secondFactor.look().then(
      (found) => {
        setState(found);
        const me = app.me.value;
        const has = found.set_up_at !== null;
        if (me && me.second_factor !== has) app.me.value = { ...me, second_factor: has };
      },
      (thrown: unknown) => setWrong(app.explain(thrown)),
    );
  };
  useEffect(load, [app]);
  useFocusKept(codes ?? state);
  const heading = usePanelReached(state !== null);
  /** Undefined until the server has responded. */
  const since = state?.set_up_at;
  const required = state?.required ?? false;
  const shown = (fresh: readonly string[] | null) => {
    setCodes(fresh);
    setAsking(null);
    load();
  };
  const kept = () => {
    setCodes(null);
    heading.current?.focus(); // the panel is lower now, so that it might be out of sight
  };
  return (
    <section class="panel" aria-labelledby={panelId}>
      <h2 id={panelId} ref={heading} tabIndex={-1}>
        {t.secondFactor.title}
      </h2>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {state === null && !wrong ? <Loading /> : null}
      {codes ? <RecoveryCodes codes={codes} onKept={kept} /> : null}
      {since === null ? <SetUp required={required} onDone={shown} /> : null}
      {state && since && !codes ? (
        <>
          <p role="status">
            {t.secondFactor.setUpSince(dayText(since))} {t.secondFactor.codesLeft(state.recovery_codes)}
          </p>
          <p class="buttons">
            <button type="button" class="button" onClick={() => setAsking("renew")}>
              {t.secondFactor.renew}
            </button>
            <button type="button" class="button" onClick={() => setAsking("remove")}>
              {t.secondFactor.remove}
            </button>
          </p>
        </>
      ) : null}
      {asking ? <AskBoth what={asking} required={required} onClose={() => setAsking(null)} onDone={shown} /> : null}
    </section>
  );
}

interface SetUpProps {
  readonly required: boolean;
  readonly onDone: (codes: readonly string[]) => void;
}

/** Asks for the password, shows the secret as a QR code and as text, then asks for the first code. */
function SetUp({ required, onDone }: SetUpProps) {
  const { password, setPassword, made, code, setCode, faults, busy, begin, confirm } = useSetUp(onDone);
  if (!made)
    return (
      <>
        <p class="muted">{t.secondFactor.about}</p>
        {required ? <Notice kind="bad">{t.secondFactor.required}</Notice> : null}
        <Form busy={busy} label={t.secondFactor.begin} {...fault(faults.form)} onSubmit={begin}>
          <CurrentPassword value={password} onInput={setPassword} {...fault(faults.password)} />
        </Form>
      </>
    );
  return (
    <>
      <p>{t.secondFactor.scan}</p>
      <QrCode text={made.uri} label={t.secondFactor.qr} />
      <p>
        {t.secondFactor.orType} <code class="secret">{made.secret.replace(/(.{4})(?=.)/g, "$1 ")}</code>
      </p>
      <Form busy={busy} label={t.secondFactor.confirm} {...fault(faults.form)} onSubmit={confirm}>
        <CodeField value={code} onInput={setCode} {...fault(faults.code)} />
      </Form>
    </>
  );
}

/** The two steps of the setup. `made` is the secret, or null until the password has been accepted. */
function useSetUp(onDone: SetUpProps["onDone"]) {
  const app = useApp();
  const [password, setPassword] = useState("");
  const [made, setMade] = useState<NewSecret | null>(null);
  const [code, setCode] = useState("");
  const [faults, setFaults] = useState<Faults<Given>>({});
  const [busy, setBusy] = useState(false);
  useFocusKept(made);
  const step = async (missing: Given | null, work: () => Promise<void>) => {
    setFaults(missing ? { [missing]: t.account.required } : {});
    if (missing) return;
    setBusy(true);
    try {
      await work();
    } catch (thrown) {
      setFaults(faultsOf(thrown, given, (what) => app.explain(what)));
    } finally {
      setBusy(false);
    }
  };
  const begin = () =>
    step(password === "" ? "password" : null, async () => {
      setMade(await app.api.secondFactor.begin(password));
      setPassword("");
    });
  const confirm = () =>
    step(code.trim() === "" ? "code" : null, async () => {
      onDone(await app.api.secondFactor.confirm(code));
    });
  return { password, setPassword, made, code, setCode, faults, busy, begin, confirm };
}

function RecoveryCodes({ codes, onKept }: { readonly codes: readonly string[]; readonly onKept: () => void }) {
  const heading = useRef<HTMLHeadingElement>(null);
  const [told, setTold] = useState("");
  const text = t.secondFactor;
  // The QR code above has disappeared, so without the focus the window would show the end of the
  // list.
  useEffect(() => heading.current?.focus(), []);
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(codes.join("\n"));
      setTold(text.copied);
    } catch {
      setTold(text.copyFailed);
    }
  };
  return (
    <div class="recovery-codes">
      <h3 ref={heading} tabIndex={-1}>
        {text.recoveryTitle}
      </h3>
      <Notice kind="good">{text.recoveryText}</Notice>
      <ol>
        {codes.map((code) => (
          <li key={code}>
            <code>{code}</code>
          </li>
        ))}
      </ol>
      <p class="buttons">
        <button type="button" class="button" onClick={() => void copy()}>
          <Icon name="copy" />
          {text.copy}
        </button>
        <button type="button" class="button button-main" onClick={onKept}>
          {text.kept}
        </button>
      </p>
      <p role="status">{told}</p>
    </div>
  );
}

interface AskBothProps {
  readonly what: "renew" | "remove";
  readonly required: boolean;
  readonly onClose: () => void;
  /** Called with the new recovery codes, if there are any. */
  readonly onDone: (codes: readonly string[] | null) => void;
}

/** Asks for the password and a code again before a change that weakens the account. */
function AskBoth({ what, required, onClose, onDone }: AskBothProps) {
  const app = useApp();
  const [password, setPassword] = useState("");
  const [code, setCode] = useState("");
  const [faults, setFaults] = useState<Faults<Given>>({});
  const [busy, setBusy] = useState(false);
  const text = t.secondFactor.ask[what];
  const submit = async () => {
    const found: Faults<Given> = {
      ...(password === "" ? { password: t.account.required } : {}),
      ...(code.trim().length < 6 ? { code: t.account.required } : {}),
    };
    setFaults(found);
    if (found.password !== undefined || found.code !== undefined) return;
    setBusy(true);
    try {
      if (what === "renew") onDone(await app.api.secondFactor.renewRecoveryCodes(password, code));
      else {
        await app.api.secondFactor.remove(password, code);
        onDone(null);
      }
    } catch (thrown) {
      setFaults(faultsOf(thrown, given, (problem) => app.explain(problem)));
      setBusy(false);
    }
  };
  return (
    <Dialog title={text.title} onClose={onClose}>
      <p>{text.text}</p>
      {what === "remove" && required ? <p>{t.secondFactor.removeRequired}</p> : null}
      <Form onSubmit={submit} busy={busy} danger={what === "remove"} label={text.yes} {...fault(faults.form)}>
        <CurrentPassword value={password} onInput={setPassword} {...fault(faults.password)} />
        <CodeField value={code} onInput={setCode} {...fault(faults.code)} />
      </Form>
      <CancelButton onClick={onClose} />
    </Dialog>
  );
}

/** Replaces the administrator's pages until two-factor authentication is set up. */
export function SecondFactorFirst() {
  return (
    <div class="page page-narrow">
      <PageTitle text={t.titles.admin} />
      <Notice kind="bad">{t.secondFactor.required}</Notice>
      <p>
        <Link href={`/account#${panelId}`} class="button button-main">
          {t.secondFactor.toAccount}
        </Link>
      </p>
    </div>
  );
}
