import { useEffect, useState } from "preact/hooks";
import type { Fleet } from "../api/types";
import { t } from "../texts";
import { Audit } from "./admin_audit";
import { Users } from "./admin_users";
import { percentText } from "./format";
import { LegalReminder } from "./legal";
import { Link } from "./router";
import { adminParts, type AdminPart } from "./routes";
import { Notice, PageTitle } from "./shell";
import { useApp } from "./state";
import { Table } from "./table";

const fleetPollIntervalMs = 2000;

export function Admin({ part }: { readonly part: AdminPart }) {
  return (
    <div class="page admin">
      <PageTitle text={t.titles.admin} />
      <LegalReminder />
      <AdminTabs at={part} />
      {part === "users" ? <Users /> : part === "audit" ? <Audit /> : <FleetState />}
    </div>
  );
}

interface AdminTabsProps {
  readonly at: AdminPart | "reports";
  /** Passed by the page that lists the reports, so that a decision changes the number at once. */
  readonly openReports?: number | null;
}

export function AdminTabs({ at, openReports }: AdminTabsProps) {
  const counted = useOpenReports(openReports === undefined);
  const open = openReports === undefined ? counted : openReports;
  return (
    <nav class="tabs" aria-label={t.titles.admin}>
      {adminParts.map((one) => (
        <Link key={one} href={`/admin/${one}`} current={one === at}>
          {t.admin.parts[one]}
        </Link>
      ))}
      <Link href="/reports" current={at === "reports"}>
        {t.sharing.reports.title}
        {open ? (
          <span class="tab-count">
            <span aria-hidden="true">{open}</span>
            <span class="visually-hidden">{` (${t.sharing.reports.openCount(open)})`}</span>
          </span>
        ) : null}
      </Link>
    </nav>
  );
}

/** The number of open reports, or null until it is known. The tab is complete without it. */
function useOpenReports(enabled: boolean): number | null {
  const app = useApp();
  const [open, setOpen] = useState<number | null>(null);
  useEffect(() => {
    if (!enabled) return;
    let here = true;
    app.api.sharing.openReports().then(
      (counted) => {
        if (here) setOpen(counted);
      },
      () => undefined,
    );
    return () => {
      here = false;
    };
  }, [app, enabled]);
  return open;
}

function FleetState() {
  const app = useApp();
  const [fleet, setFleet] = useState<Fleet | null>(null);
  const [wrong, setWrong] = useState("");
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    let here = true;
    const load = async (): Promise<void> => {
      try {
        const found = await app.api.fleet();
        if (!here) return;
        setFleet(found);
        setWrong("");
      } catch (thrown) {
        if (!here) return;
        setWrong(app.explain(thrown));
      }
      timer = setTimeout(() => void load(), fleetPollIntervalMs);
    };
    void load();
    return () => {
      here = false;
      clearTimeout(timer);
    };
  }, [app]);
  const heads = t.admin.fleetHeads;
  return (
    <>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {fleet ? <p>{t.admin.ingest(fleet.ingest.queued, fleet.ingest.building)}</p> : null}
      {fleet?.workers.length === 0 ? <Notice kind="bad">{t.admin.noWorkers}</Notice> : null}
      {fleet && fleet.workers.length > 0 ? (
        <Table
          label={t.admin.parts.fleet}
          heads={[heads.id, heads.device, heads.places, heads.load, heads.volumes, heads.state]}
          rows={fleet.workers.map((worker) => ({
            key: worker.id,
            cells: [
              worker.id,
              `${t.kernel.device(worker.device)} (${worker.engine})`,
              `${worker.used} / ${worker.slots}`,
              <span>
                <meter min={0} max={1} value={worker.load} aria-label={heads.load} /> {percentText(worker.load)}
              </span>,
              worker.volumes,
              worker.draining ? t.admin.draining : t.admin.working,
            ],
          }))}
        />
      ) : null}
    </>
  );
}
