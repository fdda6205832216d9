import { useEffect, useState } from "preact/hooks";
import { ApiProblem, exportPath } from "../api/client";
import type { BrowserSession, Export, Me } from "../api/types";
import { t } from "../texts";
import { problemText } from "../texts/problem_text";
import { looksLikeEmail } from "./account";
import { ApiTokens } from "./api_tokens";
import { CodeField } from "./code_field";
import { CancelButton, Dialog } from "./dialog";
import { CurrentPassword, EmailField } from "./field";
import { Form, fault, faultsOf, type Faults } from "./form";
import { bytesText, dateText, dayShortText, dayText } from "./format";
import { Loading } from "./loading";
import { NewPassword } from "./new_password";
import { navigate } from "./router";
import { SecondFactor } from "./second_factor";
import { Notice, PageTitle, useFocusKept } from "./shell";
import { useApp } from "./state";
import { shortestPassword } from "./strength";

const askedAgainAfterMs = 2000;

export function MyAccount({ me }: { readonly me: Me }) {
  return (
    <div class="page page-narrow my-account">
      <PageTitle text={t.titles.account} />
      <Room me={me} />
      <Browsers />
      <Address me={me} />
      <Password />
      <SecondFactor />
      <ApiTokens coded={me.second_factor} />
      <Data />
      <Removal coded={me.second_factor} />
    </div>
  );
}

function Room({ me }: { readonly me: Me }) {
  const { quota, render_time: time } = me;
  const day = dayText(time.renewed_at);
  return (
    <section class="panel" aria-labelledby="room">
      <h2 id="room">{t.myAccount.room}</h2>
      <Used
        label={t.myAccount.storage}
        part={quota.used_bytes}
        all={quota.bytes}
        text={t.myAccount.storageUsed(bytesText(quota.used_bytes), bytesText(quota.bytes))}
      />
      <Used
        label={t.myAccount.time}
        part={time.used_ms}
        all={time.quota_ms}
        text={t.myAccount.timeUsed(t.myAccount.hours(time.used_ms), t.myAccount.hours(time.quota_ms))}
      />
      {time.used_ms >= time.quota_ms ? <Notice kind="bad">{t.myAccount.timeSpent(day)}</Notice> : null}
      <p class="muted">{t.myAccount.timeHelp(day)}</p>
    </section>
  );
}

function Used({
  label,
  part,
  all,
  text,
}: {
  readonly label: string;
  readonly part: number;
  readonly all: number;
  readonly text: string;
}) {
  return (
    <div class="used">
      <span>{label}</span>
      <meter min={0} max={Math.max(all, 1)} value={Math.min(part, all)} aria-label={label} />
      <span>{text}</span>
    </div>
  );
}

/** The browsers in which the user is signed in. */
function Browsers() {
  const { items, wrong, end, endAll } = useBrowserSessions();
  useFocusKept(items?.length);
  return (
    <section class="panel" aria-labelledby="browsers">
      <h2 id="browsers">{t.myAccount.browsers}</h2>
      <p class="muted">{t.myAccount.browsersHelp}</p>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {items === null && !wrong ? <Loading /> : null}
      <ul class="rows">
        {(items ?? []).map((one) => (
          <BrowserRow key={one.id} session={one} end={() => end(one)} />
        ))}
      </ul>
      <p>
        <button type="button" class="button" onClick={endAll}>
          {t.myAccount.endAll}
        </button>
      </p>
    </section>
  );
}

function useBrowserSessions() {
  const app = useApp();
  const [items, setItems] = useState<readonly BrowserSession[] | null>(null);
  const [wrong, setWrong] = useState("");
  const explain = (thrown: unknown) => setWrong(app.explain(thrown));
  const load = () => {
    app.api.browserSessions().then(setItems, (thrown: unknown) => setWrong(app.explain(thrown)));
  };
  useEffect(load, [app]);
  const end = (one: BrowserSession) => {
    app.api.endBrowserSession(one.id).then(load, explain);
  };
  const endAll = () => {
    app.api.signOutEverywhere().then(() => {
      app.me.value = null;
      navigate("/sign-in");
    }, explain);
  };
  return { items, wrong, end, endAll };
}

function BrowserRow({ session, end }: { readonly session: BrowserSession; readonly end: () => void }) {
  const name = t.sharing.views.browser(session.browser || t.myAccount.aBrowser);
  return (
    <li>
      <span>
        <strong>{name}</strong> {session.current ? <span class="chip chip-accent">{t.myAccount.thisOne}</span> : null}
        <span class="muted row-more">
          {t.myAccount.since(dayShortText(session.created_at))}, {t.myAccount.used(dateText(session.used_at))}
        </span>
      </span>
      {session.current ? null : (
        <button type="button" class="button button-small" aria-label={t.myAccount.endOneOf(name)} onClick={end}>
          {t.myAccount.endOne}
        </button>
      )}
    </li>
  );
}

function Address({ me }: { readonly me: Me }) {
  const app = useApp();
  const [email, setEmail] = useState("");
  const [password, setPassword] = useState("");
  const [faults, setFaults] = useState<Faults<"email" | "password">>({});
  const [busy, setBusy] = useState(false);
  const [sent, setSent] = useState("");
  const submit = async () => {
    setSent("");
    const found: Faults<"email" | "password"> = {
      ...(looksLikeEmail(email) ? {} : { email: email === "" ? t.account.required : t.account.emailWrong }),
      ...(password === "" ? { password: t.account.required } : {}),
    };
    setFaults(found);
    if (found.email !== undefined || found.password !== undefined) return;
    setBusy(true);
    try {
      await app.api.changeEmail(email.trim(), password);
      setSent(email.trim());
      setEmail("");
      setPassword("");
    } catch (thrown) {
      setFaults(faultsOf(thrown, ["email", "password"], (what) => app.explain(what)));
    } finally {
      setBusy(false);
    }
  };
  return (
    <section class="panel" aria-labelledby="address">
      <h2 id="address">{t.myAccount.address}</h2>
      <p>{t.myAccount.addressNow(me.email)}</p>
      {sent ? <Notice kind="good">{t.myAccount.addressSent(sent)}</Notice> : null}
      <Form onSubmit={submit} busy={busy} label={t.myAccount.changeAddress} {...fault(faults.form)}>
        <EmailField
          label={t.myAccount.newAddress}
          autocomplete="email"
          value={email}
          onInput={setEmail}
          {...fault(faults.email)}
        />
        <CurrentPassword value={password} onInput={setPassword} {...fault(faults.password)} />
      </Form>
    </section>
  );
}

function Password() {
  const app = useApp();
  const [current, setCurrent] = useState("");
  const [password, setPassword] = useState("");
  const [faults, setFaults] = useState<Faults<"current" | "password">>({});
  const [busy, setBusy] = useState(false);
  const [done, setDone] = useState(false);
  const submit = async () => {
    setDone(false);
    const found: Faults<"current" | "password"> = {
      ...(current === "" ? { current: t.account.required } : {}),
      ...(Array.from(password).length >= shortestPassword ? {} : { password: t.account.passwordShort }),
    };
    setFaults(found);
    if (found.current !== undefined || found.password !== undefined) return;
    setBusy(true);
    try {
      await app.api.changePassword(current, password);
      setDone(true);
      setCurrent("");
      setPassword("");
    } catch (thrown) {
      setFaults(faultsOf(thrown, ["current", "password"], (what) => app.explain(what)));
    } finally {
      setBusy(false);
    }
  };
  return (
    <section class="panel" aria-labelledby="password">
      <h2 id="password">{t.myAccount.password}</h2>
      {done ? <Notice kind="good">{t.myAccount.passwordChanged}</Notice> : null}
      <Form onSubmit={submit} busy={busy} label={t.myAccount.changePassword} {...fault(faults.form)}>
        <CurrentPassword value={current} onInput={setCurrent} {...fault(faults.current)} />
        <NewPassword label={t.account.newPassword} value={password} onInput={setPassword} {...fault(faults.password)} />
      </Form>
    </section>
  );
}

/** The export of all data that is stored about the user. */
function Data() {
  const { made, wrong, request, remove } = useExport();
  useFocusKept(made?.state);
  return (
    <section class="panel" aria-labelledby="data">
      <h2 id="data">{t.myAccount.data}</h2>
      <p class="muted">{t.myAccount.exportHelp}</p>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {made?.state === "queued" ? (
        <p role="status">{made.waiting ? t.myAccount.exportWaiting : t.myAccount.exportQueued}</p>
      ) : null}
      {made?.state === "failed" ? <Notice kind="bad">{t.myAccount.exportFailed}</Notice> : null}
      {made?.state === "ready" ? <ExportReady made={made} remove={remove} /> : null}
      {made === null || made.state === "failed" ? (
        <p>
          <button type="button" class="button" onClick={request}>
            {t.myAccount.exportAsk}
          </button>
        </p>
      ) : null}
    </section>
  );
}

function ExportReady({ made, remove }: { readonly made: Export; readonly remove: () => void }) {
  return (
    <>
      <p role="status">
        {t.myAccount.exportReady(bytesText(made.bytes ?? 0))} {t.myAccount.exportUntil(dateText(made.expires_at))}
      </p>
      <p class="buttons">
        <a class="button button-main" href={exportPath} download>
          {t.myAccount.exportGet}
        </a>
        <button type="button" class="button" onClick={remove}>
          {t.myAccount.exportDelete}
        </button>
      </p>
    </>
  );
}

/** The state of the export, which is polled while it is queued. */
function useExport() {
  const app = useApp();
  const [made, setMade] = useState<Export | null>(null);
  const [wrong, setWrong] = useState("");
  const [round, setRound] = useState(0);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    let here = true;
    app.api.exportState().then(
      (state) => {
        if (!here) return;
        setMade(state);
        if (state?.state === "queued") timer = setTimeout(() => setRound(round + 1), askedAgainAfterMs);
      },
      (thrown: unknown) => here && setWrong(app.explain(thrown)),
    );
    return () => {
      here = false;
      clearTimeout(timer);
    };
  }, [app, round]);
  const act = (what: () => Promise<unknown>) => {
    setWrong("");
    what().then(
      () => setRound(round + 1),
      (thrown: unknown) => setWrong(app.explain(thrown)),
    );
  };
  return {
    made,
    wrong,
    request: () => act(() => app.api.requestExport()),
    remove: () => act(() => app.api.deleteExport()),
  };
}

/**
 * The deletion of the account. `coded` means that it has a second factor, so that a code is needed
 * too.
 */
function Removal({ coded }: { readonly coded: boolean }) {
  const { asking, setAsking, password, setPassword, code, setCode, faults, busy, close, submit } = useRemoval(coded);
  return (
    <section class="panel" aria-labelledby="removal">
      <h2 id="removal">{t.myAccount.remove}</h2>
      <p class="muted">{t.myAccount.removeHelp}</p>
      <p>
        <button type="button" class="button button-danger" onClick={() => setAsking(true)}>
          {t.myAccount.removeAsk}
        </button>
      </p>
      {asking ? (
        <Dialog title={t.myAccount.removeTitle} onClose={close}>
          <p>{t.myAccount.removeText}</p>
          <Form onSubmit={submit} busy={busy} danger label={t.myAccount.removeYes} {...fault(faults.form)}>
            <CurrentPassword value={password} onInput={setPassword} {...fault(faults.password)} />
            {coded ? <CodeField value={code} onInput={setCode} {...fault(faults.code)} /> : null}
          </Form>
          <CancelButton onClick={close} />
        </Dialog>
      ) : null}
    </section>
  );
}

/** The password and the code that deleting the account requires. */
function useRemoval(coded: boolean) {
  const app = useApp();
  const [asking, setAsking] = useState(false);
  const [password, setPassword] = useState("");
  const [code, setCode] = useState("");
  const [faults, setFaults] = useState<Faults<"password" | "code">>({});
  const [busy, setBusy] = useState(false);
  const close = () => {
    setAsking(false);
    setPassword("");
    setCode("");
    setFaults({});
  };
  const submit = async () => {
    const found: Faults<"password" | "code"> = {
      ...(password === "" ? { password: t.account.required } : {}),
      ...(coded && code.trim() === "" ? { code: t.account.required } : {}),
    };
    setFaults(found);
    if (found.password !== undefined || found.code !== undefined) return;
    setBusy(true);
    try {
      app.uploads.stopAll();
      await app.api.deleteAccount(password, code.trim());
      app.leave(t.myAccount.removed);
      navigate("/");
    } catch (thrown) {
      const wrongCode = thrown instanceof ApiProblem && thrown.kind === "wrong-code";
      setFaults(
        wrongCode ? { code: problemText(thrown) } : faultsOf(thrown, ["password"], (what) => app.explain(what)),
      );
      setBusy(false);
    }
  };
  return { asking, setAsking, password, setPassword, code, setCode, faults, busy, close, submit };
}
