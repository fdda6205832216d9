import { useEffect, useMemo, useState } from "preact/hooks";
import { ApiProblem } from "../api/client";
import { SentElsewhere } from "../api/uploads";
import { bundleSize } from "../scan/bundle";
import { DamagedPiece, type Piece } from "../scan/piece";
import type { Series } from "../scan/types";
import { partBlobs, sizesOf } from "../scan/upload_plan";
import { t } from "../texts";
import { bytesText } from "./format";
import { navigate } from "./router";
import { useApp } from "./state";

/**
 * The upload of one series: its size, whether it was interrupted before, and what prevents it. The list stays open for
 * the others, unless it is the `only` one.
 */
export function useSeriesUpload(
  series: Series,
  files: readonly File[],
  unpacked: readonly (Piece | null)[],
  only: boolean,
) {
  const app = useApp();
  const [busy, setBusy] = useState(false);
  const [fault, setFault] = useState("");
  const [begun, setBegun] = useState(false);
  // Computes the size without the parts, because a disc has thousands and only an upload needs them.
  const bytes = useMemo(() => bundleSize(sizesOf(series.upload)), [series]);
  const interruptedAt = useInterruption(series.fingerprint, bytes);
  const quota = app.me.value?.quota;
  const free = quota ? Math.max(0, quota.bytes - quota.used_bytes) : Infinity;
  const overQuota = interruptedAt === null && bytes > free ? t.add.overQuota(bytesText(bytes), bytesText(free)) : "";
  const start = async (title: string) => {
    setBusy(true);
    setFault("");
    try {
      await app.uploads.start(await partBlobs(series.upload, files, unpacked), title, series.fingerprint);
      if (only) navigate("/scans");
      else setBegun(true);
    } catch (thrown) {
      setFault(uploadFault(thrown, bytes, free) ?? app.explain(thrown));
      setBusy(false);
    }
  };
  return { bytes, busy, begun, interruptedAt, fault: fault || overQuota, start };
}

/** The percentage of these files that an interrupted upload has sent, or null if there is none. */
function useInterruption(fingerprint: string, bytes: number): number | null {
  const app = useApp();
  const [percent, setPercent] = useState<number | null>(null);
  useEffect(() => {
    void app.uploads
      .interrupted(fingerprint, bytes)
      .then((earlier) => setPercent(earlier ? Math.floor((100 * earlier.received) / bytes) : null))
      .catch(() => undefined); // the check is repeated when the upload starts
  }, [app, fingerprint, bytes]);
  return percent;
}

/** Returns the message for an error that only an upload can have, or null. */
function uploadFault(thrown: unknown, bytes: number, free: number): string | null {
  if (thrown instanceof SentElsewhere) return t.add.sentElsewhere;
  if (thrown instanceof DamagedPiece) return t.add.damagedInArchive;
  if (!(thrown instanceof ApiProblem)) return null;
  switch (thrown.kind) {
    case "over-quota":
      return free < bytes ? t.add.overQuota(bytesText(bytes), bytesText(free)) : null;
    case "storage-full":
      return t.add.storageFull;
    case "upload-too-large":
      return t.add.tooLarge;
    default:
      return null;
  }
}
