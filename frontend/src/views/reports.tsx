import { useCallback, useEffect, useState } from "preact/hooks";
import type { Report, TakeDown } from "../api/types";
import { t } from "../texts";
import { AdminTabs } from "./admin";
import { Dialog } from "./dialog";
import { Field } from "./field";
import { dateText } from "./format";
import { Loading } from "./loading";
import { Link } from "./router";
import { Notice, PageTitle, useFocusKept } from "./shell";
import { useApp } from "./state";

/** Returns the name of the preset or of the scan that the report is about. */
const nameOf = (of: Pick<Report, "preset_name" | "title">): string => of.preset_name || of.title;
const reasonOf = ({ preset_id: presetId, reason }: Report): string | undefined =>
  (presetId === null ? undefined : t.sharing.report.reasonsPreset[reason]) ?? t.sharing.report.reasons[reason];

/** For administrators: reports about public scans and presets, and everything that is taken down. */
export function Reports() {
  const app = useApp();
  const { reports, takenDown, fault, takeDown, lift, dismiss } = useReports();
  const [taking, setTaking] = useState<Report | null>(null);
  const text = t.sharing.reports;
  useFocusKept(reports?.length);
  return (
    <div class="page">
      <PageTitle text={t.titles.admin} />
      {app.me.value?.administrator ? <AdminTabs at="reports" openReports={reports?.length ?? null} /> : null}
      <p class="muted">{text.lead}</p>
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
      {reports === null && !fault ? <Loading /> : null}
      {reports?.length === 0 ? <p role="status">{text.none}</p> : null}
      <ul class="saved-presets" aria-label={text.title}>
        {reports?.map((report) => (
          <ReportItem
            key={report.id}
            report={report}
            onTakeDown={() => setTaking(report)}
            onDismiss={() => dismiss(report)}
          />
        ))}
      </ul>
      {takenDown ? <TakenDown items={takenDown} lift={lift} /> : null}
      {taking ? (
        <TakeDownDialog
          report={taking}
          onClose={() => setTaking(null)}
          takeDown={(reason) => {
            setTaking(null);
            takeDown(taking, reason);
          }}
        />
      ) : null}
    </div>
  );
}

/** The open reports, and everything that is taken down. Both are loaded again after each decision. */
function useReports() {
  const app = useApp();
  const [reports, setReports] = useState<readonly Report[] | null>(null);
  const [takenDown, setTakenDown] = useState<readonly TakeDown[] | null>(null);
  const [fault, setFault] = useState("");
  const load = useCallback(async () => {
    try {
      setReports(await app.api.sharing.reports());
      setTakenDown(await app.api.sharing.takeDowns());
    } catch (thrown) {
      setFault(app.explain(thrown));
    }
  }, [app]);
  useEffect(() => void load(), [load]);
  const act = (work: Promise<void>) => {
    setFault("");
    work.then(load, (thrown: unknown) => setFault(app.explain(thrown)));
  };
  return {
    reports,
    takenDown,
    fault,
    takeDown: (report: Report, reason: string) => act(app.api.sharing.takeDown(report, reason)),
    lift: (one: TakeDown) => act(app.api.sharing.liftTakeDown(one)),
    dismiss: (report: Report) => act(app.api.sharing.dismiss(report.id)),
  };
}

interface ReportItemProps {
  readonly report: Report;
  readonly onTakeDown: () => void;
  readonly onDismiss: () => void;
}

function ReportItem({ report, onTakeDown, onDismiss }: ReportItemProps) {
  const text = t.sharing.reports;
  return (
    <li data-report-id={report.id}>
      {report.title ? <h2 class="card-title">{report.title}</h2> : null}
      <p>
        <strong>{reasonOf(report)}</strong> <small class="muted">{dateText(report.created_at)}</small>
      </p>
      {report.preset_name ? <p>{text.preset(report.preset_name)}</p> : null}
      {report.words ? <p class="card-description">{report.words}</p> : null}
      <div class="saved-acts">
        {report.title ? (
          <Link
            class="button button-small"
            href={`/view/${report.data_set_id}`}
            label={t.sharing.gallery.open(report.title)}
          >
            {text.open}
          </Link>
        ) : (
          <span class="muted">{text.isPrivate}</span>
        )}
        {report.title && !report.taken_down ? (
          <button
            type="button"
            class="button button-small button-danger"
            aria-label={text.takeDownOf(nameOf(report))}
            onClick={onTakeDown}
          >
            {text.takeDown}
          </button>
        ) : null}
        <button
          type="button"
          class="button button-small"
          aria-label={text.dismissOf(nameOf(report))}
          onClick={onDismiss}
        >
          {text.dismiss}
        </button>
      </div>
    </li>
  );
}

interface TakenDownProps {
  readonly items: readonly TakeDown[];
  readonly lift: (one: TakeDown) => void;
}

/** Everything that is taken down, with the reasons and a button to restore it. */
function TakenDown({ items, lift }: TakenDownProps) {
  const [lifting, setLifting] = useState<TakeDown | null>(null);
  const text = t.sharing.reports;
  return (
    <section aria-labelledby="taken-down">
      <h2 id="taken-down">{text.takenDown}</h2>
      {items.length === 0 ? <p class="muted">{text.noneTakenDown}</p> : null}
      <ul class="saved-presets" aria-label={text.takenDown}>
        {items.map((one) => (
          <li key={one.preset_id ?? one.data_set_id}>
            <h3 class="card-title">{one.preset_id === null ? one.title : text.preset(one.preset_name)}</h3>
            <p>
              {one.reason} <small class="muted">{dateText(one.taken_down_at)}</small>
            </p>
            {one.preset_id === null ? null : <p class="muted">{one.title}</p>}
            <div class="saved-acts">
              <button
                type="button"
                class="button button-small"
                aria-label={text.liftOf(nameOf(one))}
                onClick={() => setLifting(one)}
              >
                {text.lift}
              </button>
            </div>
          </li>
        ))}
      </ul>
      {lifting ? (
        <Dialog title={text.liftOf(nameOf(lifting))} onClose={() => setLifting(null)}>
          <p>{lifting.preset_id === null ? text.liftLead : text.liftPresetLead}</p>
          <div class="dialog-buttons">
            <button type="button" class="button" onClick={() => setLifting(null)}>
              {t.cancel}
            </button>
            <button
              type="button"
              class="button button-main"
              onClick={() => {
                lift(lifting);
                setLifting(null);
              }}
            >
              {text.lift}
            </button>
          </div>
        </Dialog>
      ) : null}
    </section>
  );
}

interface TakeDownDialogProps {
  readonly report: Report;
  readonly takeDown: (reason: string) => void;
  readonly onClose: () => void;
}

function TakeDownDialog({ report, takeDown, onClose }: TakeDownDialogProps) {
  const [reason, setReason] = useState("");
  const text = t.sharing.reports;
  return (
    <Dialog title={text.takeDownOf(nameOf(report))} onClose={onClose}>
      <p>{report.preset_id === null ? text.takeDownLead : text.takeDownPresetLead}</p>
      <Field label={text.reason} value={reason} onInput={setReason} most={500} hint={text.reasonHint} />
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onClose}>
          {t.cancel}
        </button>
        <button
          type="button"
          class="button button-danger"
          disabled={reason.trim() === ""}
          onClick={() => takeDown(reason.trim())}
        >
          {text.takeDown}
        </button>
      </div>
    </Dialog>
  );
}
