import { useEffect, useState } from "preact/hooks";
import type { NewSecret, SecondFactor as State } from "../api/second_factor";
import { t } from "../texts";
import { CodeField } from "./code_field";
import { Dialog } from "./dialog";
import { Field } from "./field";
import { Form, fault, faults_of, type Faults } from "./form";
import { day_text } from "./format";
import { QrCode } from "./qr_code";
import { Link } from "./router";
import { Notice, PageTitle, use_focus_kept } from "./shell";
import { useApp } from "./state";

type Given = "password" | "code";
const given: readonly Given[] = ["password", "code"];

/** The panel of one's own account: set up, renewed, removed. */
export function SecondFactor() {
  const app = useApp();
  const [state, set_state] = useState<State | null>(null);
  const [wrong, set_wrong] = useState("");
  const [codes, set_codes] = useState<readonly string[] | null>(null);
  const [asking, set_asking] = useState<"renew" | "remove" | null>(null);
  const load = () => {
    app.api.second_factor.look().then(
      (found) => {
        set_state(found);
        const me = app.me.value;
        const has = found.set_up_at !== null;
        if (me && me.second_factor !== has) app.me.value = { ...me, second_factor: has };
      },
      (thrown: unknown) => set_wrong(app.explain(thrown)),
    );
  };
  useEffect(load, [app]);
  use_focus_kept(codes ?? state);
  /** Undefined: not known yet. */
  const since = state?.set_up_at;
  const required = state?.required ?? false;
  const shown = (fresh: readonly string[] | null) => {
    set_codes(fresh);
    set_asking(null);
    load();
  };
  return (
    <section class="panel" aria-labelledby="second-factor">
      <h2 id="second-factor">{t.second_factor.title}</h2>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {state === null && !wrong ? <p class="muted" role="status">{t.loading}</p> : null}
      {codes ? <RecoveryCodes codes={codes} onKept={() => set_codes(null)} /> : null}
      {since === null ? <SetUp required={required} onDone={shown} /> : null}
      {state && since && !codes ? (
        <>
          <p role="status">{t.second_factor.set_up_since(day_text(since))} {t.second_factor.codes_left(state.recovery_codes)}</p>
          <p class="buttons">
            <button type="button" class="button" onClick={() => set_asking("renew")}>{t.second_factor.renew}</button>
            <button type="button" class="button" onClick={() => set_asking("remove")}>{t.second_factor.remove}</button>
          </p>
        </>
      ) : null}
      {asking ? <AskBoth what={asking} required={required} onClose={() => set_asking(null)} onDone={shown} /> : null}
    </section>
  );
}

/** The password, then the secret as a picture and as text, then the first code. */
function SetUp({ required, onDone }: { readonly required: boolean; readonly onDone: (codes: readonly string[]) => void }) {
  const app = useApp();
  const [password, set_password] = useState("");
  const [made, set_made] = useState<NewSecret | null>(null);
  const [code, set_code] = useState("");
  const [faults, set_faults] = useState<Faults<Given>>({});
  const [busy, set_busy] = useState(false);
  use_focus_kept(made);
  const step = async (missing: Given | null, work: () => Promise<void>) => {
    set_faults(missing ? { [missing]: t.account.required } : {});
    if (missing) return;
    set_busy(true);
    try {
      await work();
    } catch (thrown) {
      set_faults(faults_of(thrown, given, (what) => app.explain(what)));
    } finally {
      set_busy(false);
    }
  };
  if (!made)
    return (
      <>
        <p class="muted">{t.second_factor.about}</p>
        {required ? <Notice kind="bad">{t.second_factor.required}</Notice> : null}
        <Form busy={busy} label={t.second_factor.begin} {...fault(faults.form)} onSubmit={() => step(password === "" ? "password" : null, async () => {
          set_made(await app.api.second_factor.begin(password));
          set_password("");
        })}>
          <Field label={t.my_account.current} type="password" autocomplete="current-password" value={password} onInput={set_password} {...fault(faults.password)} />
        </Form>
      </>
    );
  return (
    <>
      <p>{t.second_factor.scan}</p>
      <QrCode text={made.uri} label={t.second_factor.qr} />
      <p>{t.second_factor.or_type} <code class="secret">{made.secret.replace(/(.{4})(?=.)/g, "$1 ")}</code></p>
      <Form busy={busy} label={t.second_factor.confirm} {...fault(faults.form)} onSubmit={() => step(code.trim() === "" ? "code" : null, async () => {
        onDone(await app.api.second_factor.confirm(code));
      })}>
        <CodeField value={code} onInput={set_code} {...fault(faults.code)} />
      </Form>
    </>
  );
}

function RecoveryCodes({ codes, onKept }: { readonly codes: readonly string[]; readonly onKept: () => void }) {
  return (
    <div class="recovery-codes">
      <h3>{t.second_factor.recovery_title}</h3>
      <Notice kind="good">{t.second_factor.recovery_text}</Notice>
      <ol>{codes.map((code) => <li key={code}><code>{code}</code></li>)}</ol>
      <p><button type="button" class="button button-main" onClick={onKept}>{t.second_factor.kept}</button></p>
    </div>
  );
}

interface AskBothProps {
  readonly what: "renew" | "remove";
  readonly required: boolean;
  readonly onClose: () => void;
  /** With new recovery codes, or none. */
  readonly onDone: (codes: readonly string[] | null) => void;
}

/** Password and code once more, before what weakens the account. */
function AskBoth({ what, required, onClose, onDone }: AskBothProps) {
  const app = useApp();
  const [password, set_password] = useState("");
  const [code, set_code] = useState("");
  const [faults, set_faults] = useState<Faults<Given>>({});
  const [busy, set_busy] = useState(false);
  const text = t.second_factor.ask[what];
  const submit = async () => {
    const found: Faults<Given> = {
      ...(password === "" ? { password: t.account.required } : {}),
      ...(code.trim().length < 6 ? { code: t.account.required } : {}),
    };
    set_faults(found);
    if (found.password !== undefined || found.code !== undefined) return;
    set_busy(true);
    try {
      if (what === "renew") onDone(await app.api.second_factor.renew_recovery_codes(password, code));
      else {
        await app.api.second_factor.remove(password, code);
        onDone(null);
      }
    } catch (thrown) {
      set_faults(faults_of(thrown, given, (problem) => app.explain(problem)));
      set_busy(false);
    }
  };
  return (
    <Dialog title={text.title} onClose={onClose}>
      <p>{text.text}</p>
      {what === "remove" && required ? <p>{t.second_factor.remove_required}</p> : null}
      <Form onSubmit={submit} busy={busy} danger={what === "remove"} label={text.yes} {...fault(faults.form)}>
        <Field label={t.my_account.current} type="password" autocomplete="current-password" value={password} onInput={set_password} {...fault(faults.password)} />
        <CodeField value={code} onInput={set_code} {...fault(faults.code)} />
      </Form>
      <div class="dialog-buttons"><button type="button" class="button" onClick={onClose}>{t.cancel}</button></div>
    </Dialog>
  );
}

/** In place of an administrator's page. */
export function SecondFactorFirst() {
  return (
    <div class="page page-narrow">
      <PageTitle text={t.titles.admin} />
      <Notice kind="bad">{t.second_factor.required}</Notice>
      <p><Link href="/account" class="button button-main">{t.second_factor.to_account}</Link></p>
    </div>
  );
}
