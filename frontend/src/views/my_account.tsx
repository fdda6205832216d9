import { useEffect, useState } from "preact/hooks";
import { export_path } from "../api/client";
import type { BrowserSession, Export, Me } from "../api/types";
import { tab } from "../storage";
import { t } from "../texts";
import { looks_like_email } from "./account";
import { Dialog } from "./dialog";
import { Field } from "./field";
import { Form, fault, faults_of, type Faults } from "./form";
import { bytes_text, date_text, day_text } from "./format";
import { NewPassword } from "./new_password";
import { navigate } from "./router";
import { SecondFactor } from "./second_factor";
import { Notice, PageTitle, use_focus_kept } from "./shell";
import { useApp } from "./state";
import { shortest_password } from "./strength";

const asked_again_after_ms = 2000;

export function MyAccount({ me }: { readonly me: Me }) {
  return (
    <div class="page page-narrow my-account">
      <PageTitle text={t.titles.account} />
      <Room me={me} />
      <Browsers />
      <Address me={me} />
      <Password />
      <SecondFactor />
      <Data />
      <Removal />
    </div>
  );
}

function Room({ me }: { readonly me: Me }) {
  const { quota, render_time: time } = me;
  const day = day_text(time.renewed_at);
  return (
    <section class="panel" aria-labelledby="room">
      <h2 id="room">{t.my_account.room}</h2>
      <Used label={t.my_account.storage} part={quota.used_bytes} all={quota.bytes}
        text={t.my_account.storage_used(bytes_text(quota.used_bytes), bytes_text(quota.bytes))} />
      <Used label={t.my_account.time} part={time.used_ms} all={time.quota_ms}
        text={t.my_account.time_used(t.my_account.hours(time.used_ms), t.my_account.hours(time.quota_ms))} />
      {time.used_ms >= time.quota_ms ? <Notice kind="bad">{t.my_account.time_spent(day)}</Notice> : null}
      <p class="muted">{t.my_account.time_help(day)}</p>
    </section>
  );
}

function Used({ label, part, all, text }: { readonly label: string; readonly part: number; readonly all: number; readonly text: string }) {
  return (
    <div class="used">
      <span>{label}</span>
      <meter min={0} max={Math.max(all, 1)} value={Math.min(part, all)} aria-label={label} />
      <span>{text}</span>
    </div>
  );
}

function Browsers() {
  const app = useApp();
  const [items, set_items] = useState<readonly BrowserSession[] | null>(null);
  const [wrong, set_wrong] = useState("");
  use_focus_kept(items?.length);
  const load = () => {
    app.api.browser_sessions().then(set_items, (thrown: unknown) => set_wrong(app.explain(thrown)));
  };
  useEffect(load, [app]);
  const end = (one: BrowserSession) => {
    app.api.end_browser_session(one.id).then(load, (thrown: unknown) => set_wrong(app.explain(thrown)));
  };
  const end_all = () => {
    app.api.sign_out_everywhere().then(
      () => {
        app.me.value = null;
        navigate("/sign-in");
      },
      (thrown: unknown) => set_wrong(app.explain(thrown)),
    );
  };
  return (
    <section class="panel" aria-labelledby="browsers">
      <h2 id="browsers">{t.my_account.browsers}</h2>
      <p class="muted">{t.my_account.browsers_help}</p>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {items === null && !wrong ? <p class="muted" role="status">{t.loading}</p> : null}
      <ul class="rows">
        {(items ?? []).map((one) => {
          const name = one.browser || t.my_account.a_browser;
          return (
            <li key={one.id}>
              <span>
                <strong>{name}</strong> {one.current ? <span class="chip chip-accent">{t.my_account.this_one}</span> : null}
                <span class="muted row-more">{t.my_account.since(day_text(one.created_at))}, {t.my_account.used(date_text(one.used_at))}</span>
              </span>
              {one.current ? null : (
                <button type="button" class="button button-small" aria-label={t.my_account.end_one_of(name)} onClick={() => end(one)}>{t.my_account.end_one}</button>
              )}
            </li>
          );
        })}
      </ul>
      <p><button type="button" class="button" onClick={end_all}>{t.my_account.end_all}</button></p>
    </section>
  );
}

function Address({ me }: { readonly me: Me }) {
  const app = useApp();
  const [email, set_email] = useState("");
  const [password, set_password] = useState("");
  const [faults, set_faults] = useState<Faults<"email" | "password">>({});
  const [busy, set_busy] = useState(false);
  const [sent, set_sent] = useState("");
  const submit = async () => {
    set_sent("");
    const found: Faults<"email" | "password"> = {
      ...(looks_like_email(email) ? {} : { email: email === "" ? t.account.required : t.account.email_wrong }),
      ...(password === "" ? { password: t.account.required } : {}),
    };
    set_faults(found);
    if (found.email !== undefined || found.password !== undefined) return;
    set_busy(true);
    try {
      await app.api.change_email(email.trim(), password);
      set_sent(email.trim());
      set_email("");
      set_password("");
    } catch (thrown) {
      set_faults(faults_of(thrown, ["email", "password"], (what) => app.explain(what)));
    } finally {
      set_busy(false);
    }
  };
  return (
    <section class="panel" aria-labelledby="address">
      <h2 id="address">{t.my_account.address}</h2>
      <p>{t.my_account.address_now(me.email)}</p>
      {sent ? <Notice kind="good">{t.my_account.address_sent(sent)}</Notice> : null}
      <Form onSubmit={submit} busy={busy} label={t.my_account.change_address} {...fault(faults.form)}>
        <Field label={t.my_account.new_address} type="email" autocomplete="email" value={email} onInput={set_email} {...fault(faults.email)} />
        <Field label={t.my_account.current} type="password" autocomplete="current-password" value={password} onInput={set_password} {...fault(faults.password)} />
      </Form>
    </section>
  );
}

function Password() {
  const app = useApp();
  const [current, set_current] = useState("");
  const [password, set_password] = useState("");
  const [faults, set_faults] = useState<Faults<"current" | "password">>({});
  const [busy, set_busy] = useState(false);
  const [done, set_done] = useState(false);
  const submit = async () => {
    set_done(false);
    const found: Faults<"current" | "password"> = {
      ...(current === "" ? { current: t.account.required } : {}),
      ...(Array.from(password).length >= shortest_password ? {} : { password: t.account.password_short }),
    };
    set_faults(found);
    if (found.current !== undefined || found.password !== undefined) return;
    set_busy(true);
    try {
      await app.api.change_password(current, password);
      set_done(true);
      set_current("");
      set_password("");
    } catch (thrown) {
      set_faults(faults_of(thrown, ["current", "password"], (what) => app.explain(what)));
    } finally {
      set_busy(false);
    }
  };
  return (
    <section class="panel" aria-labelledby="password">
      <h2 id="password">{t.my_account.password}</h2>
      {done ? <Notice kind="good">{t.my_account.password_changed}</Notice> : null}
      <Form onSubmit={submit} busy={busy} label={t.my_account.change_password} {...fault(faults.form)}>
        <Field label={t.my_account.current} type="password" autocomplete="current-password" value={current} onInput={set_current} {...fault(faults.current)} />
        <NewPassword label={t.account.new_password} value={password} onInput={set_password} {...fault(faults.password)} />
      </Form>
    </section>
  );
}

function Data() {
  const app = useApp();
  const [made, set_made] = useState<Export | null>(null);
  use_focus_kept(made?.state);
  const [wrong, set_wrong] = useState("");
  const [round, set_round] = useState(0);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    let here = true;
    app.api.export_state().then(
      (state) => {
        if (!here) return;
        set_made(state);
        if (state?.state === "queued") timer = setTimeout(() => set_round(round + 1), asked_again_after_ms);
      },
      (thrown: unknown) => here && set_wrong(app.explain(thrown)),
    );
    return () => {
      here = false;
      clearTimeout(timer);
    };
  }, [app, round]);
  const act = (what: () => Promise<unknown>) => {
    set_wrong("");
    what().then(() => set_round(round + 1), (thrown: unknown) => set_wrong(app.explain(thrown)));
  };
  return (
    <section class="panel" aria-labelledby="data">
      <h2 id="data">{t.my_account.data}</h2>
      <p class="muted">{t.my_account.export_help}</p>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {made?.state === "queued" ? <p role="status">{made.waiting ? t.my_account.export_waiting : t.my_account.export_queued}</p> : null}
      {made?.state === "failed" ? <Notice kind="bad">{t.my_account.export_failed}</Notice> : null}
      {made?.state === "ready" ? (
        <>
          <p role="status">{t.my_account.export_ready(bytes_text(made.bytes ?? 0))} {t.my_account.export_until(date_text(made.expires_at))}</p>
          <p class="buttons">
            <a class="button button-main" href={export_path} download>{t.my_account.export_get}</a>
            <button type="button" class="button" onClick={() => act(() => app.api.delete_export())}>{t.my_account.export_delete}</button>
          </p>
        </>
      ) : null}
      {made === null || made.state === "failed" ? (
        <p><button type="button" class="button" onClick={() => act(() => app.api.request_export())}>{t.my_account.export_ask}</button></p>
      ) : null}
    </section>
  );
}

function Removal() {
  const app = useApp();
  const [asking, set_asking] = useState(false);
  const [password, set_password] = useState("");
  const [faults, set_faults] = useState<Faults<"password">>({});
  const [busy, set_busy] = useState(false);
  const close = () => {
    set_asking(false);
    set_password("");
    set_faults({});
  };
  const submit = async () => {
    if (password === "") {
      set_faults({ password: t.account.required });
      return;
    }
    set_busy(true);
    try {
      app.uploads.stop_all();
      await app.api.delete_account(password);
      tab.clear();
      app.me.value = null;
      navigate("/sign-up");
    } catch (thrown) {
      set_faults(faults_of(thrown, ["password"], (what) => app.explain(what)));
      set_busy(false);
    }
  };
  return (
    <section class="panel" aria-labelledby="removal">
      <h2 id="removal">{t.my_account.remove}</h2>
      <p class="muted">{t.my_account.remove_help}</p>
      <p><button type="button" class="button button-danger" onClick={() => set_asking(true)}>{t.my_account.remove_ask}</button></p>
      {asking ? (
        <Dialog title={t.my_account.remove_title} onClose={close}>
          <p>{t.my_account.remove_text}</p>
          <Form onSubmit={submit} busy={busy} danger label={t.my_account.remove_yes} {...fault(faults.form)}>
            <Field label={t.my_account.current} type="password" autocomplete="current-password" value={password} onInput={set_password} {...fault(faults.password)} />
          </Form>
          <div class="dialog-buttons"><button type="button" class="button" onClick={close}>{t.cancel}</button></div>
        </Dialog>
      ) : null}
    </section>
  );
}
