import { useEffect, useState } from "preact/hooks";
import type { DataSet } from "../../api/types";
import { local } from "../../storage";
import { place, t } from "../../texts";
import { CancelButton, Dialog } from "../dialog";
import { Loading } from "../loading";
import { lookOf } from "../looks";
import { Link, navigate } from "../router";
import { comparePath } from "../routes";
import { KindChip, titleOf } from "../scan_card";
import { inOrder, orderKey, scanOrderOf } from "../scan_order";
import { Notice } from "../shell";
import { useApp } from "../state";
import { useThumbnail } from "../thumbnail";

/** Chooses the scan to compare another one with: of the user's own scans, shared ones and samples. */
export function ChooseScanDialog({ first, onClose }: { readonly first: DataSet; readonly onClose: () => void }) {
  const app = useApp();
  const [sets, setSets] = useState<readonly DataSet[] | null>(null);
  const [fault, setFault] = useState("");
  useEffect(() => {
    const leaving = new AbortController();
    app.api.dataSets(leaving.signal).then(
      (all) => setSets(all.filter((set) => set.state === "ready" && set.id !== first.id)),
      (thrown: unknown) => {
        if (!leaving.signal.aborted) setFault(app.explain(thrown));
      },
    );
    return () => leaving.abort();
  }, [app, first.id]);
  const text = t.compare;
  return (
    <Dialog title={text.choose} onClose={onClose}>
      <p class="muted">{text.chooseLead(titleOf(first))}</p>
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
      {sets === null && !fault ? <Loading /> : null}
      {sets?.length === 0 ? (
        <p>
          {text.none} <Link href="/add">{t.scans.add}</Link>
        </p>
      ) : null}
      <ul class="choose-scans">
        {nearestFirst(sets ?? []).map((set) => (
          <li key={set.id}>
            <ScanChoice set={set} choose={() => navigate(comparePath(first.id, set.id))} />
          </li>
        ))}
      </ul>
      <CancelButton onClick={onClose} />
    </Dialog>
  );
}

/** The user's own scans first and samples last, in the order of the list of scans. */
const nearestFirst = (sets: readonly DataSet[]): readonly DataSet[] =>
  [...inOrder(sets, scanOrderOf(local.getItem(orderKey)), place())].sort((a, b) => rank(a) - rank(b));

const rank = (set: DataSet): number => (set.owned ? 0 : set.is_sample ? 2 : 1);

function ScanChoice({ set, choose }: { readonly set: DataSet; readonly choose: () => void }) {
  const { url } = useThumbnail(set.id, lookOf(set), true);
  return (
    <button type="button" class="choose-scan" onClick={choose}>
      <span class="choose-picture">{url ? <img src={url} alt="" width={320} height={320} /> : null}</span>
      <span class="choose-name">{titleOf(set)}</span>
      {set.is_sample ? <span class="chip chip-accent">{t.scans.sample}</span> : null}
      <KindChip set={set} />
    </button>
  );
}
