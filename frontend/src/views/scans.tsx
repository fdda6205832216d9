import { useState } from "preact/hooks";
import type { DataSet } from "../api/types";
import type { UploadView } from "../api/upload_view";
import { local } from "../storage";
import { place, t } from "../texts";
import { Choice } from "./choice";
import { ChooseScanDialog } from "./compare/choose_scan";
import { Dialog } from "./dialog";
import { bytesText } from "./format";
import { addFiles } from "./files_for_add";
import { Icon } from "./icons";
import { LabelsDialog } from "./labels/labels_dialog";
import { Loading } from "./loading";
import { Link } from "./router";
import { RenameDialog } from "./rename_dialog";
import { ScanCard, titleOf } from "./scan_card";
import { inOrder, orderKey, scanOrderOf, scanOrders, type ScanOrder } from "./scan_order";
import { Notice, PageTitle, useFocusKept } from "./shell";
import { useApp } from "./state";
import { useWarmThumbnails } from "./thumbnail";
import { useDroppedFiles } from "./use_dropped_files";
import { useScans } from "./use_scans";
import { ViewLogDialog } from "./view_log";

/** The number of newest scans whose pictures are prepared before they are opened. */
const warmed = 4;

export function Scans() {
  const app = useApp();
  const { sets, fault, remove, rename, reload } = useScans();
  const [removing, setRemoving] = useState<DataSet | null>(null);
  const [renaming, setRenaming] = useState<DataSet | null>(null);
  const [viewsOf, setViewsOf] = useState<DataSet | null>(null);
  const [labelsOf, setLabelsOf] = useState<DataSet | null>(null);
  const [comparing, setComparing] = useState<DataSet | null>(null);
  useFocusKept(sets?.length);
  useDroppedFiles(addFiles);
  return (
    <div class="page">
      <div class="page-head">
        <div>
          <PageTitle text={t.titles.scans} />
          <QuotaMeter />
        </div>
        <Link href="/add" class="button button-main">
          <Icon name="plus" />
          {t.scans.add}
        </Link>
      </div>
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
      {sets === null && !fault ? <Loading /> : null}
      {sets ? (
        <List
          sets={sets}
          uploads={app.uploads.views.value}
          onRemove={setRemoving}
          onRename={setRenaming}
          onViews={setViewsOf}
          onLabels={setLabelsOf}
          onCompare={setComparing}
        />
      ) : null}
      {labelsOf ? (
        <LabelsDialog
          set={labelsOf}
          onClose={() => {
            setLabelsOf(null);
            reload();
          }}
        />
      ) : null}
      {comparing ? <ChooseScanDialog first={comparing} onClose={() => setComparing(null)} /> : null}
      {viewsOf ? <ViewLogDialog dataSetId={viewsOf.id} onClose={() => setViewsOf(null)} /> : null}
      {renaming ? <RenameDialog set={renaming} rename={rename} onClose={() => setRenaming(null)} /> : null}
      {removing ? (
        <RemoveDialog
          set={removing}
          onNo={() => setRemoving(null)}
          onYes={() => {
            setRemoving(null);
            void remove(removing);
          }}
        />
      ) : null}
    </div>
  );
}

function QuotaMeter() {
  const quota = useApp().me.value?.quota;
  if (!quota || quota.bytes <= 0) return null;
  return (
    <div class="quota">
      <meter min={0} max={quota.bytes} value={quota.used_bytes} aria-hidden="true" />
      <span>{t.scans.used(bytesText(quota.used_bytes), bytesText(quota.bytes))}</span>
    </div>
  );
}

interface RemoveDialogProps {
  readonly set: DataSet;
  readonly onNo: () => void;
  readonly onYes: () => void;
}

function RemoveDialog({ set, onNo, onYes }: RemoveDialogProps) {
  const uploading = set.state === "uploading";
  const text = t.scans;
  return (
    <Dialog title={uploading ? text.cancelTitle : text.removeTitle} onClose={onNo}>
      <p>{uploading ? text.cancelText(titleOf(set)) : text.removeText(titleOf(set))}</p>
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onNo}>
          {uploading ? text.cancelNo : t.cancel}
        </button>
        <button type="button" class="button button-danger" onClick={onYes}>
          {uploading ? text.cancelYes : text.removeYes}
        </button>
      </div>
    </Dialog>
  );
}

/** The choice of the order, which is remembered in this browser. */
function OrderChoice({
  order,
  onChoose,
}: {
  readonly order: ScanOrder;
  readonly onChoose: (order: ScanOrder) => void;
}) {
  return (
    <div class="scan-order">
      <Choice
        label={t.scans.order}
        value={order}
        options={scanOrders.map((one) => [one, t.scans.orders[one]] as const)}
        onChoose={(chosen) => {
          onChoose(scanOrderOf(chosen));
          local.setItem(orderKey, chosen);
        }}
      />
    </div>
  );
}

function NoScans() {
  return (
    <section class="empty">
      <Icon name="folder" />
      <h2>{t.scans.empty}</h2>
      <p>{t.scans.leadEmpty}</p>
      <Link href="/add" class="button button-main">
        {t.scans.add}
      </Link>
    </section>
  );
}

interface ListProps {
  readonly sets: readonly DataSet[];
  readonly uploads: ReadonlyMap<string, UploadView>;
  readonly onRemove: (set: DataSet) => void;
  readonly onRename: (set: DataSet) => void;
  readonly onViews: (set: DataSet) => void;
  readonly onLabels: (set: DataSet) => void;
  readonly onCompare: (set: DataSet) => void;
}

function List({ sets, uploads, onRemove, onRename, onViews, onLabels, onCompare }: ListProps) {
  useWarmThumbnails(sets.filter((set) => set.state === "ready").slice(0, warmed));
  const [order, setOrder] = useState(() => scanOrderOf(local.getItem(orderKey)));
  const ordered = inOrder(sets, order, place());
  const own = ordered.filter((set) => set.owned);
  const shared = ordered.filter((set) => !set.owned && !set.is_sample);
  const samples = sets.filter((set) => !set.owned && set.is_sample);
  const comparable = sets.filter((set) => set.state === "ready").length > 1;
  const card = (set: DataSet) => (
    <li key={set.id}>
      <ScanCard
        set={set}
        upload={uploads.get(set.id) ?? null}
        onRemove={() => onRemove(set)}
        onRename={() => onRename(set)}
        onViews={() => onViews(set)}
        onLabels={() => onLabels(set)}
        onCompare={comparable ? () => onCompare(set) : null}
      />
    </li>
  );
  const sharedPart =
    shared.length > 0 ? (
      <section class="others">
        <h2>{t.sharing.withMe}</h2>
        <p class="muted">{t.sharing.views.toldPerson}</p>
        <ul class="cards">{shared.map(card)}</ul>
      </section>
    ) : null;
  return (
    <>
      {own.length === 0 ? (
        // People who were invited to a scan come for that scan.
        <>
          {sharedPart}
          <NoScans />
        </>
      ) : (
        <>
          <section>
            <h2 class="visually-hidden">{t.scans.list}</h2>
            {own.length > 1 ? <OrderChoice order={order} onChoose={setOrder} /> : null}
            <ul class="cards">{own.map(card)}</ul>
          </section>
          {sharedPart}
        </>
      )}
      {samples.length > 0 ? (
        <section class="others">
          <h2>{t.scans.examples}</h2>
          <ul class="cards">{samples.map(card)}</ul>
        </section>
      ) : null}
    </>
  );
}
