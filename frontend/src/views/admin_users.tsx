import { useState } from "preact/hooks";
import type { User } from "../api/types";
import { typedNumber } from "../scene/numbers";
import { t } from "../texts";
import { Address } from "./address";
import { Dialog } from "./dialog";
import { Field } from "./field";
import { Form, fault, faultsOf, type Faults } from "./form";
import { bytesText, dateText, numberText } from "./format";
import { Loading } from "./loading";
import { MoreButton } from "./more_button";
import { navigate } from "./router";
import { Notice } from "./shell";
import { useApp } from "./state";
import { Table } from "./table";
import { usePages } from "./use_pages";

/** All accounts, with a search. */
export function Users() {
  const app = useApp();
  const [query, setQuery] = useState("");
  const [changing, setChanging] = useState<User | null>(null);
  const { items, next, wrong, begin, more } = usePages((cursor) => app.api.users(query.trim(), cursor));
  return (
    <>
      <form
        class="filter"
        role="search"
        onSubmit={(event) => {
          event.preventDefault();
          begin();
        }}
      >
        <Field label={t.admin.search} value={query} onInput={setQuery} />
        <button type="submit" class="button">
          {t.admin.find}
        </button>
      </form>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {items === null && !wrong ? <Loading /> : null}
      {items?.length === 0 ? <p role="status">{t.admin.none}</p> : null}
      {items && items.length > 0 ? <UserTable users={items} change={setChanging} /> : null}
      {next ? <MoreButton onClick={more} /> : null}
      {changing ? (
        <UserDialog
          user={changing}
          onClose={(changed) => {
            setChanging(null);
            if (changed) begin();
          }}
        />
      ) : null}
    </>
  );
}

interface UserTableProps {
  readonly users: readonly User[];
  readonly change: (user: User) => void;
}

function UserTable({ users, change }: UserTableProps) {
  const heads = t.admin.heads;
  return (
    <Table
      label={t.admin.parts.users}
      heads={[heads.email, heads.state, heads.scans, heads.storage, heads.time, heads.seen, heads.change]}
      rows={users.map((user) => ({
        key: user.id,
        cells: [
          <Address email={user.email} />,
          <States user={user} />,
          user.data_sets,
          t.myAccount.storageUsed(bytesText(user.quota.used_bytes), bytesText(user.quota.bytes)),
          t.myAccount.timeUsed(
            t.myAccount.hours(user.render_time.used_ms),
            t.myAccount.hours(user.render_time.quota_ms),
          ),
          user.used_at ? dateText(user.used_at) : t.admin.never,
          <button
            type="button"
            class="button button-small"
            aria-label={t.admin.changeOf(user.email)}
            onClick={() => change(user)}
          >
            {t.admin.change}
          </button>,
        ],
      }))}
    />
  );
}

function States({ user }: { readonly user: User }) {
  const plain = user.verified && !user.disabled && !user.administrator && !user.researcher && !user.archive_access;
  return (
    <span class="chips">
      {user.administrator ? <span class="chip chip-accent">{t.admin.administrator}</span> : null}
      {user.researcher ? <span class="chip chip-accent">{t.admin.researcher}</span> : null}
      {user.archive_access ? <span class="chip chip-accent">{t.admin.archive}</span> : null}
      {user.disabled ? <span class="chip chip-refused">{t.admin.disabled}</span> : null}
      {user.verified ? null : <span class="chip">{t.admin.notVerified}</span>}
      {plain ? <span class="chip chip-good">{t.admin.active}</span> : null}
    </span>
  );
}

const gigabyte = 1e9;
const hourMs = 3_600_000;

interface UserDialogProps {
  readonly user: User;
  /** `changed` tells whether the list is out of date. */
  readonly onClose: (changed: boolean) => void;
}

/** The limits of an account, and whether it is enabled. */
function UserDialog({ user, onClose }: UserDialogProps) {
  const app = useApp();
  const form = useUserForm(user, () => onClose(true));
  const { gb, setGb, hours, setHours, faults, busy, save, setDisabled } = form;
  return (
    <Dialog title={user.email} onClose={() => onClose(false)}>
      <Form onSubmit={save} busy={busy} label={t.admin.save} {...fault(faults.form)}>
        <Field label={t.admin.quotaGb} value={gb} onInput={setGb} {...fault(faults.quota_bytes)} />
        <Field label={t.admin.renderHours} value={hours} onInput={setHours} {...fault(faults.render_quota_ms)} />
      </Form>
      <Roles user={user} form={form} />
      {user.id === app.me.value?.id ? null : (
        <>
          {user.disabled ? null : <p class="muted">{t.admin.switchOffText}</p>}
          <p>
            <button
              type="button"
              class={user.disabled ? "button" : "button button-danger"}
              disabled={busy}
              onClick={() => void setDisabled(!user.disabled)}
            >
              {user.disabled ? t.admin.switchOn : t.admin.switchOff}
            </button>
          </p>
        </>
      )}
      <div class="dialog-buttons">
        <button
          type="button"
          class="button"
          onClick={() => {
            onClose(false);
            navigate(`/admin/audit?account=${user.id}`);
          }}
        >
          {t.admin.entriesOf}
        </button>
        <button type="button" class="button" onClick={() => onClose(false)}>
          {t.close}
        </button>
      </div>
    </Dialog>
  );
}

interface RolesProps {
  readonly user: User;
  readonly form: ReturnType<typeof useUserForm>;
}

/** Gives and withdraws what an account may do besides using its own scans. */
function Roles({ user, form }: RolesProps) {
  const { busy, setResearcher, setArchiveAccess } = form;
  return (
    <>
      <p class="muted">{t.admin.researcherText}</p>
      <p>
        <button type="button" class="button" disabled={busy} onClick={() => void setResearcher(!user.researcher)}>
          {user.researcher ? t.admin.withdrawResearcher : t.admin.makeResearcher}
        </button>
      </p>
      <p class="muted">{t.admin.archiveText}</p>
      <p>
        <button
          type="button"
          class="button"
          disabled={busy}
          onClick={() => void setArchiveAccess(!user.archive_access)}
        >
          {user.archive_access ? t.admin.withdrawArchive : t.admin.giveArchive}
        </button>
      </p>
    </>
  );
}

const inTenths = (value: number): string => numberText(Math.round(value * 10) / 10);
const limits = { low: 0, high: 1e9 };

/**
 * The entries of the dialog and its actions. `onChanged` is called when the server has accepted a
 * change.
 */
function useUserForm(user: User, onChanged: () => void) {
  const app = useApp();
  const [gb, setGb] = useState(inTenths(user.quota.bytes / gigabyte));
  const [hours, setHours] = useState(inTenths(user.render_time.quota_ms / hourMs));
  const [faults, setFaults] = useState<Faults<"quota_bytes" | "render_quota_ms">>({});
  const [busy, setBusy] = useState(false);
  const send = async (change: Parameters<typeof app.api.changeUser>[1]) => {
    setBusy(true);
    try {
      await app.api.changeUser(user.id, change);
      onChanged();
    } catch (thrown) {
      setFaults(faultsOf(thrown, ["quota_bytes", "render_quota_ms"], (what) => app.explain(what)));
      setBusy(false);
    }
  };
  const save = async () => {
    const storage = typedNumber(gb, limits);
    const time = typedNumber(hours, limits);
    setFaults({
      ...(storage === null ? { quota_bytes: t.admin.numberWrong } : {}),
      ...(time === null ? { render_quota_ms: t.admin.numberWrong } : {}),
    });
    if (storage === null || time === null) return;
    await send({ quota_bytes: Math.round(storage * gigabyte), render_quota_ms: Math.round(time * hourMs) });
  };
  const setDisabled = (disabled: boolean) => send({ disabled });
  const setResearcher = (researcher: boolean) => send({ researcher });
  const setArchiveAccess = (access: boolean) => send({ archive_access: access });
  return { gb, setGb, hours, setHours, faults, busy, save, setDisabled, setResearcher, setArchiveAccess };
}
