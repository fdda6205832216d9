import { useState } from "preact/hooks";
import { scanExportPath, type ScanExport, type ScanFormat } from "../../../api/scan_exports";
import { Modality, type VolumeHeader } from "../../../protocol/messages";
import { exportOrderOf, usualThreshold, type ExportEntries } from "../../../scene/export_order";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { Choice } from "../../choice";
import { Field } from "../../field";
import { fault as faulty } from "../../form";
import { bytesText, dateText } from "../../format";
import { nameOf } from "../../labels/label_name";
import { Notice } from "../../shell";
import { useScanExport } from "./use_scan_export";
import { TakeForm } from "./take_form";

export interface ScanFileProps {
  readonly session: ViewerSession;
  readonly dataSetId: string;
}

/** A file of the scan, or of the surface of one of its parts, for other programs. */
export function ScanFile({ session, dataSetId }: ScanFileProps) {
  const text = t.scanFile;
  const { made, wrong, busy, request, remove } = useScanExport(dataSetId);
  const volume = session.volume.value;
  if (!volume || made === undefined) return wrong ? <Notice kind="bad">{wrong}</Notice> : null;
  return (
    <>
      <p class="muted">{text.lead}</p>
      <Notice kind="warn">{text.warning}</Notice>
      {made?.state === "queued" ? (
        <div class="take-form">
          <p role="status">{made.waiting ? text.waiting : text.queued}</p>
          <p>
            <button type="button" class="button" disabled={busy} onClick={remove}>
              {text.stop}
            </button>
          </p>
        </div>
      ) : null}
      {made?.state === "failed" ? <Notice kind="bad">{failureOf(made)}</Notice> : null}
      {made?.state === "ready" ? <Ready made={made} dataSetId={dataSetId} busy={busy} remove={remove} /> : null}
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {made === null || made.state === "failed" ? (
        <OrderForm session={session} volume={volume} busy={busy} request={request} />
      ) : null}
    </>
  );
}

function failureOf({ problem }: ScanExport): string {
  const known: Readonly<Record<string, string>> = t.scanFile.failures;
  return known[problem?.code ?? ""] ?? t.scanFile.failed;
}

interface ReadyProps {
  readonly made: ScanExport;
  readonly dataSetId: string;
  readonly busy: boolean;
  readonly remove: () => void;
}

function Ready({ made, dataSetId, busy, remove }: ReadyProps) {
  const text = t.scanFile;
  return (
    <div class="take-form">
      <p role="status">
        {text.ready(text.formats[made.format], bytesText(made.bytes ?? 0))}{" "}
        {t.myAccount.exportUntil(dateText(made.expires_at))}
      </p>
      <p class="buttons">
        <a class="button" href={scanExportPath(dataSetId)} download>
          {text.get}
        </a>
        <button type="button" class="button" disabled={busy} onClick={remove}>
          {text.another}
        </button>
      </p>
    </div>
  );
}

interface OrderFormProps {
  readonly session: ViewerSession;
  readonly volume: VolumeHeader;
  readonly busy: boolean;
  readonly request: ReturnType<typeof useScanExport>["request"];
}

function OrderForm({ session, volume, busy, request }: OrderFormProps) {
  const text = t.scanFile;
  const isCt = volume.modality === Modality.CT;
  const [entries, setEntries] = useState<ExportEntries>({
    format: "nifti",
    part: "",
    above: String(usualThreshold(volume, isCt, volume.percentiles)),
  });
  const [fault, setFault] = useState("");
  const set = (part: Partial<ExportEntries>) => {
    setEntries({ ...entries, ...part });
    setFault("");
  };
  const submit = () => {
    const shown = session.editor.scene.value?.volumePhase ?? 0;
    const order = exportOrderOf(entries, volume, Math.min(shown, Math.max(volume.phases.length, 1) - 1));
    if (order) request(order);
    else setFault(text.wrongAbove(volume.minimum, volume.maximum));
  };
  return (
    <TakeForm onSubmit={submit}>
      <Choice
        label={text.format}
        value={entries.format}
        options={Object.entries(text.formats)}
        onChoose={(format) => set({ format: format as ScanFormat })}
      />
      <p class="muted">{text.formatHints[entries.format]}</p>
      {entries.format === "nifti" ? null : (
        <Part session={session} volume={volume} entries={entries} fault={fault} set={set} />
      )}
      <p>
        <button type="submit" class="button" disabled={busy}>
          {text.create}
        </button>
      </p>
    </TakeForm>
  );
}

interface PartProps extends Pick<OrderFormProps, "session" | "volume"> {
  readonly entries: ExportEntries;
  readonly fault: string;
  readonly set: (part: Partial<ExportEntries>) => void;
}

/** The label, or the value, whose surface becomes the model. */
function Part({ session, volume, entries, fault, set }: PartProps) {
  const text = t.scanFile;
  const isCt = volume.modality === Modality.CT;
  const labels = session.labels.value;
  return (
    <>
      {labels.length > 0 ? (
        <Choice
          label={text.part}
          value={entries.part}
          options={[["", text.byValue], ...labels.map((label) => [String(label.number), nameOf(label)] as const)]}
          onChoose={(part) => set({ part })}
        />
      ) : null}
      {entries.part === "" ? (
        <Field
          label={isCt ? text.aboveHounsfield : text.above}
          value={entries.above}
          onInput={(above) => set({ above })}
          hint={isCt ? text.aboveHintCt : text.aboveHint(volume.minimum, volume.maximum)}
          most={7}
          {...faulty(fault)}
        />
      ) : null}
    </>
  );
}
