import { useEffect, useState } from "preact/hooks";
import type { Report } from "../api/types";
import { t } from "../texts";
import { AdminTabs } from "./admin";
import { Dialog } from "./dialog";
import { Field } from "./field";
import { date_text } from "./format";
import { Link } from "./router";
import { Notice, PageTitle, use_focus_kept } from "./shell";
import { useApp } from "./state";

/** What it is about. */
const name_of = (report: Report): string => report.preset_name || report.title;
const reason_of = ({ preset_id, reason }: Report): string | undefined =>
  (preset_id === null ? undefined : t.sharing.report.reasons_preset[reason]) ?? t.sharing.report.reasons[reason];

/** For an administrator: what people said is wrong with public scans, and with presets for them. */
export function Reports() {
  const app = useApp();
  const [reports, set_reports] = useState<readonly Report[] | null>(null);
  const [taking, set_taking] = useState<Report | null>(null);
  const [reason, set_reason] = useState("");
  const [fault, set_fault] = useState("");
  const text = t.sharing.reports;
  use_focus_kept(reports?.length);

  const load = () => app.api.sharing.reports().then(set_reports, (thrown: unknown) => set_fault(app.explain(thrown)));
  useEffect(() => void load(), [app]);
  const act = (work: Promise<void>) => {
    set_fault("");
    work.then(load, (thrown: unknown) => set_fault(app.explain(thrown)));
  };
  const take_down = (report: Report) => {
    set_taking(null);
    act(app.api.sharing.take_down(report, reason.trim()));
  };
  return (
    <div class="page">
      <PageTitle text={text.title} />
      {app.me.value?.administrator ? <AdminTabs at="reports" /> : null}
      <p class="muted">{text.lead}</p>
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
      {reports === null && !fault ? <p class="muted" role="status">{t.loading}</p> : null}
      {reports?.length === 0 ? <p role="status">{text.none}</p> : null}
      <ul class="saved-presets" aria-label={text.title}>
        {reports?.map((report) => (
          <li key={report.id} data-report-id={report.id}>
            {report.title ? <h2 class="card-title">{report.title}</h2> : null}
            <p><strong>{reason_of(report)}</strong> <small class="muted">{date_text(report.created_at)}</small></p>
            {report.preset_name ? <p>{text.preset(report.preset_name)}</p> : null}
            {report.words ? <p class="card-description">{report.words}</p> : null}
            <div class="saved-acts">
              {report.title ? <Link class="button button-small" href={`/view/${report.data_set_id}`} label={t.sharing.gallery.open(report.title)}>{text.open}</Link> : <span class="muted">{text.is_private}</span>}
              {report.title && !report.taken_down ? (
                <button type="button" class="button button-small button-danger" aria-label={text.take_down_of(name_of(report))} onClick={() => {
                  set_reason("");
                  set_taking(report);
                }}>{text.take_down}</button>
              ) : null}
              <button type="button" class="button button-small" aria-label={text.dismiss_of(name_of(report))} onClick={() => act(app.api.sharing.dismiss(report.id))}>{text.dismiss}</button>
            </div>
          </li>
        ))}
      </ul>
      {taking ? (
        <Dialog title={text.take_down_of(name_of(taking))} onClose={() => set_taking(null)}>
          <p>{taking.preset_id === null ? text.take_down_lead : text.take_down_preset_lead}</p>
          <Field label={text.reason} value={reason} onInput={set_reason} most={500} hint={text.reason_hint} />
          <div class="dialog-buttons">
            <button type="button" class="button" onClick={() => set_taking(null)}>{t.cancel}</button>
            <button type="button" class="button button-danger" disabled={reason.trim() === ""} onClick={() => take_down(taking)}>{text.take_down}</button>
          </div>
        </Dialog>
      ) : null}
    </div>
  );
}
