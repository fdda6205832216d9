import { useEffect, useState } from "preact/hooks";
import type { AuditEntry, Fleet, User } from "../api/types";
import { t } from "../texts";
import { Dialog } from "./dialog";
import { Field } from "./field";
import { Form, fault, faults_of, type Faults } from "./form";
import { bytes_text, date_text } from "./format";
import { Link, navigate } from "./router";
import { admin_parts, type AdminPart } from "./routes";
import { Notice, PageTitle } from "./shell";
import { useApp } from "./state";
import { Table } from "./table";

const fleet_asked_every_ms = 2000;

export function Admin({ part }: { readonly part: AdminPart }) {
  return (
    <div class="page admin">
      <PageTitle text={t.titles.admin} />
      <AdminTabs at={part} />
      {part === "users" ? <Users /> : part === "audit" ? <Audit /> : <FleetState />}
    </div>
  );
}

export function AdminTabs({ at }: { readonly at: AdminPart | "reports" }) {
  return (
    <nav class="tabs" aria-label={t.titles.admin}>
      {admin_parts.map((one) => <Link key={one} href={`/admin/${one}`} current={one === at}>{t.admin.parts[one]}</Link>)}
      <Link href="/reports" current={at === "reports"}>{t.sharing.reports.title}</Link>
    </nav>
  );
}

/** A list that is read page by page; what it is asked for anew begins again. */
function use_pages<T>(load: (cursor: string | null) => Promise<{ items: readonly T[]; next_cursor: string | null }>) {
  const app = useApp();
  const [items, set_items] = useState<readonly T[] | null>(null);
  const [next, set_next] = useState<string | null>(null);
  const [wrong, set_wrong] = useState("");
  const read = (cursor: string | null, before: readonly T[]) => {
    load(cursor).then(
      (page) => {
        set_items([...before, ...page.items]);
        set_next(page.next_cursor);
        set_wrong("");
      },
      (thrown: unknown) => set_wrong(app.explain(thrown)),
    );
  };
  return { items, next, wrong, begin: () => read(null, []), more: () => read(next, items ?? []) };
}

function Users() {
  const app = useApp();
  const [query, set_query] = useState("");
  const [changing, set_changing] = useState<User | null>(null);
  const { items, next, wrong, begin, more } = use_pages((cursor) => app.api.users(query.trim(), cursor));
  useEffect(begin, [app]);
  const heads = t.admin.heads;
  return (
    <>
      <form class="filter" role="search" onSubmit={(event) => {
        event.preventDefault();
        begin();
      }}>
        <Field label={t.admin.search} value={query} onInput={set_query} />
        <button type="submit" class="button">{t.admin.find}</button>
      </form>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {items === null && !wrong ? <p class="muted" role="status">{t.loading}</p> : null}
      {items?.length === 0 ? <p role="status">{t.admin.none}</p> : null}
      {items && items.length > 0 ? (
        <Table
          label={t.admin.parts.users}
          heads={[heads.email, heads.state, heads.scans, heads.storage, heads.time, heads.seen, heads.change]}
          rows={items.map((user) => ({ key: user.id, cells: [
            user.email,
            <States user={user} />,
            user.data_sets,
            t.my_account.storage_used(bytes_text(user.quota.used_bytes), bytes_text(user.quota.bytes)),
            t.my_account.time_used(t.my_account.hours(user.render_time.used_ms), t.my_account.hours(user.render_time.quota_ms)),
            user.used_at ? date_text(user.used_at) : t.admin.never,
            <button type="button" class="button button-small" aria-label={t.admin.change_of(user.email)} onClick={() => set_changing(user)}>{t.admin.change}</button>,
          ] }))}
        />
      ) : null}
      {next ? <p><button type="button" class="button" onClick={more}>{t.admin.more}</button></p> : null}
      {changing ? (
        <UserDialog user={changing} onClose={(changed) => {
          set_changing(null);
          if (changed) begin();
        }} />
      ) : null}
    </>
  );
}

function States({ user }: { readonly user: User }) {
  const plain = user.verified && !user.disabled && !user.administrator;
  return (
    <span class="chips">
      {user.administrator ? <span class="chip chip-accent">{t.admin.administrator}</span> : null}
      {user.disabled ? <span class="chip chip-refused">{t.admin.disabled}</span> : null}
      {user.verified ? null : <span class="chip">{t.admin.not_verified}</span>}
      {plain ? <span class="chip chip-good">{t.admin.active}</span> : null}
    </span>
  );
}

const gigabyte = 1e9;
const hour_ms = 3_600_000;

function UserDialog({ user, onClose }: { readonly user: User; readonly onClose: (changed: boolean) => void }) {
  const app = useApp();
  const [gb, set_gb] = useState(String(Math.round((user.quota.bytes / gigabyte) * 10) / 10));
  const [hours, set_hours] = useState(String(Math.round((user.render_time.quota_ms / hour_ms) * 10) / 10));
  const [faults, set_faults] = useState<Faults<"quota_bytes" | "render_quota_ms">>({});
  const [busy, set_busy] = useState(false);
  const send = async (change: Parameters<typeof app.api.change_user>[1]) => {
    set_busy(true);
    try {
      await app.api.change_user(user.id, change);
      onClose(true);
    } catch (thrown) {
      set_faults(faults_of(thrown, ["quota_bytes", "render_quota_ms"], (what) => app.explain(what)));
      set_busy(false);
    }
  };
  const save = async () => {
    const wrong = (text: string) => text.trim() === "" || !(Number(text) >= 0);
    const found = {
      ...(wrong(gb) ? { quota_bytes: t.admin.number_wrong } : {}),
      ...(wrong(hours) ? { render_quota_ms: t.admin.number_wrong } : {}),
    };
    set_faults(found);
    if (Object.keys(found).length > 0) return;
    await send({ quota_bytes: Math.round(Number(gb) * gigabyte), render_quota_ms: Math.round(Number(hours) * hour_ms) });
  };
  return (
    <Dialog title={user.email} onClose={() => onClose(false)}>
      <Form onSubmit={save} busy={busy} label={t.admin.save} {...fault(faults.form)}>
        <Field label={t.admin.quota_gb} value={gb} onInput={set_gb} {...fault(faults.quota_bytes)} />
        <Field label={t.admin.render_hours} value={hours} onInput={set_hours} {...fault(faults.render_quota_ms)} />
      </Form>
      {user.id === app.me.value?.id ? null : (
        <>
          {user.disabled ? null : <p class="muted">{t.admin.switch_off_text}</p>}
          <p>
            <button type="button" class={user.disabled ? "button" : "button button-danger"} disabled={busy} onClick={() => void send({ disabled: !user.disabled })}>
              {user.disabled ? t.admin.switch_on : t.admin.switch_off}
            </button>
          </p>
        </>
      )}
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={() => {
          onClose(false);
          navigate(`/admin/audit?account=${user.id}`);
        }}>{t.admin.entries_of}</button>
        <button type="button" class="button" onClick={() => onClose(false)}>{t.close}</button>
      </div>
    </Dialog>
  );
}

/** A day as it is typed into a field for days, as a moment; nothing for an empty one. */
const start_of = (day: string): string | null => (day ? `${day}T00:00:00Z` : null);

function Audit() {
  const app = useApp();
  const [account, set_account] = useState(new URLSearchParams(location.search).get("account") ?? "");
  const [action, set_action] = useState("");
  const [from, set_from] = useState("");
  const [until, set_until] = useState("");
  const { items, next, wrong, begin, more } = use_pages((cursor) =>
    app.api.audit({ account: account.trim(), action: action.trim(), from: start_of(from), until: start_of(until), cursor }));
  useEffect(begin, [app]);
  const heads = t.admin.audit_heads;
  return (
    <>
      <p class="muted">{t.admin.kept}</p>
      <form class="filter" role="search" onSubmit={(event) => {
        event.preventDefault();
        begin();
      }}>
        <Field label={t.admin.filter_action} value={action} onInput={set_action} placeholder="account." />
        <Field label={t.admin.filter_account} value={account} onInput={set_account} />
        <Field label={t.admin.filter_from} type="date" value={from} onInput={set_from} />
        <Field label={t.admin.filter_until} type="date" value={until} onInput={set_until} />
        <button type="submit" class="button">{t.admin.filter}</button>
      </form>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {items?.length === 0 ? <p role="status">{t.admin.none}</p> : null}
      {items && items.length > 0 ? (
        <Table
          label={t.admin.parts.audit}
          heads={[heads.when, heads.who, heads.what, heads.whom, heads.details]}
          rows={items.map((entry) => ({ key: String(entry.id), cells: [
            date_text(entry.happened_at),
            who_of(entry),
            <code>{entry.action}</code>,
            entry.subject_email ?? (entry.subject_id ? `${entry.subject} ${entry.subject_id.slice(0, 8)}` : entry.subject),
            Object.entries(entry.details).map(([name, value]) => `${name} ${value}`).join(", "),
          ] }))}
        />
      ) : null}
      {next ? <p><button type="button" class="button" onClick={more}>{t.admin.more}</button></p> : null}
    </>
  );
}

function who_of(entry: AuditEntry): string {
  if (entry.actor === "machine") return t.admin.machine;
  return entry.actor_email ?? t.admin.gone;
}

function FleetState() {
  const app = useApp();
  const [fleet, set_fleet] = useState<Fleet | null>(null);
  const [wrong, set_wrong] = useState("");
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    let here = true;
    const load = async (): Promise<void> => {
      try {
        const found = await app.api.fleet();
        if (!here) return;
        set_fleet(found);
        set_wrong("");
      } catch (thrown) {
        if (!here) return;
        set_wrong(app.explain(thrown));
      }
      timer = setTimeout(() => void load(), fleet_asked_every_ms);
    };
    void load();
    return () => {
      here = false;
      clearTimeout(timer);
    };
  }, [app]);
  const heads = t.admin.fleet_heads;
  return (
    <>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {fleet ? <p>{t.admin.ingest(fleet.ingest.queued, fleet.ingest.building)}</p> : null}
      {fleet?.workers.length === 0 ? <Notice kind="bad">{t.admin.no_workers}</Notice> : null}
      {fleet && fleet.workers.length > 0 ? (
        <Table
          label={t.admin.parts.fleet}
          heads={[heads.id, heads.device, heads.places, heads.load, heads.volumes, heads.state]}
          rows={fleet.workers.map((worker) => ({ key: worker.id, cells: [
            worker.id,
            `${worker.device} (${worker.engine})`,
            `${worker.used} / ${worker.slots}`,
            <span><meter min={0} max={1} value={worker.load} aria-label={heads.load} /> {Math.round(worker.load * 100)} %</span>,
            worker.volumes,
            worker.draining ? t.admin.draining : t.admin.working,
          ] }))}
        />
      ) : null}
    </>
  );
}
