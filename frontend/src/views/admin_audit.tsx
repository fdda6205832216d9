import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import type { AuditEntry } from "../api/types";
import { t } from "../texts";
import { Address } from "./address";
import { detailsText } from "./audit_details";
import { Field } from "./field";
import { dateText } from "./format";
import { MoreButton } from "./more_button";
import { Notice } from "./shell";
import { useApp } from "./state";
import { Table } from "./table";
import { usePages } from "./use_pages";

/** Returns the first moment of the day in a date field, or null for an empty field. */
const startOf = (day: string): string | null => (day ? `${day}T00:00:00Z` : null);

/** The audit log, with its filter. A link from a user's dialog filters it by account. */
export function Audit() {
  const app = useApp();
  const [filter, setFilter] = useState<AuditFilter>(() => ({
    account: new URLSearchParams(location.search).get("account") ?? "",
    action: "",
    from: "",
    until: "",
  }));
  const { items, next, wrong, begin, more } = usePages((cursor) =>
    app.api.audit({
      account: filter.account.trim(),
      action: filter.action.trim(),
      from: startOf(filter.from),
      until: startOf(filter.until),
      cursor,
    }),
  );
  return (
    <>
      <p class="muted">{t.admin.kept}</p>
      <FilterForm filter={filter} set={(part) => setFilter((before) => ({ ...before, ...part }))} begin={begin} />
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {items?.length === 0 ? <p role="status">{t.admin.none}</p> : null}
      {items && items.length > 0 ? <AuditTable entries={items} /> : null}
      {next ? <MoreButton onClick={more} /> : null}
    </>
  );
}

interface AuditFilter {
  readonly account: string;
  readonly action: string;
  readonly from: string;
  readonly until: string;
}

interface FilterFormProps {
  readonly filter: AuditFilter;
  readonly set: (part: Partial<AuditFilter>) => void;
  readonly begin: () => void;
}

function FilterForm({ filter, set, begin }: FilterFormProps) {
  return (
    <form
      class="filter"
      role="search"
      onSubmit={(event) => {
        event.preventDefault();
        begin();
      }}
    >
      <Field
        label={t.admin.filterAction}
        value={filter.action}
        onInput={(action) => set({ action })}
        placeholder="account."
      />
      <Field label={t.admin.filterAccount} value={filter.account} onInput={(account) => set({ account })} />
      <Field label={t.admin.filterFrom} type="date" value={filter.from} onInput={(from) => set({ from })} />
      <Field label={t.admin.filterUntil} type="date" value={filter.until} onInput={(until) => set({ until })} />
      <button type="submit" class="button">
        {t.admin.filter}
      </button>
    </form>
  );
}

function AuditTable({ entries }: { readonly entries: readonly AuditEntry[] }) {
  const heads = t.admin.auditHeads;
  return (
    <Table
      label={t.admin.parts.audit}
      heads={[heads.when, heads.who, heads.what, heads.whom, heads.details]}
      rows={entries.map((entry) => ({
        key: String(entry.id),
        cells: [
          dateText(entry.happened_at),
          whoOf(entry),
          <Action code={entry.action} />,
          <span class="audit-wide">{subjectOf(entry)}</span>,
          <span class="audit-wide">{detailsText(entry)}</span>,
        ],
      }))}
    />
  );
}

/** The action in words, and the code that the filter uses. */
function Action({ code }: { readonly code: string }) {
  const text = t.admin.actions[code];
  return (
    <span class="audit-action">
      {text ? <span>{text}</span> : null}
      <code>{code}</code>
    </span>
  );
}

/** What an action was done to. A list has no ID, and the action names it already. */
function subjectOf({ subject, subject_email: subjectEmail, subject_id: subjectId }: AuditEntry): ComponentChildren {
  if (subjectEmail) return <Address email={subjectEmail} />;
  return subjectId ? `${t.admin.subjects[subject] ?? subject} ${subjectId.slice(0, 8)}` : "";
}

function whoOf(entry: AuditEntry): ComponentChildren {
  if (entry.actor === "machine") return t.admin.machine;
  if (entry.actor_id === null && ["link", "live-link"].includes(String(entry.details.by))) return t.admin.guest;
  return entry.actor_email ? <Address email={entry.actor_email} /> : t.admin.gone;
}
