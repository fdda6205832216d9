import { useEffect, useRef, useState } from "preact/hooks";
import { ApiProblem } from "../../api/client";
import type { DataSet } from "../../api/types";
import { LabelUpload, LabelUploadError } from "../../api/label_upload";
import type { StallReason } from "../../api/upload";
import { makeBundle } from "../../scan/bundle";
import { cleanLabelFile, LabelFileError } from "../../scan/label_file";
import { local } from "../../storage";
import { t } from "../../texts";
import { useApp, type AppState } from "../state";
import { useLatest } from "../use_latest";

/** The stages of a file of labels: it is read in the browser, sent, and processed by the server. */
export type LabelsPhase = "reading" | "sending" | "placing";

export interface LabelsTask {
  readonly labels: DataSet["labels"];
  /** Null if no file is being processed. */
  readonly phase: LabelsPhase | null;
  /** The fraction that was sent, from 0 to 1. */
  readonly sent: number;
  /** Why nothing can be sent at the moment. The upload resumes by itself. Null if it is not interrupted. */
  readonly stalled: StallReason | null;
  readonly fault: string;
  /** Repeats an upload that failed. Null if there is none, or if it would fail again. */
  readonly again: (() => Promise<void>) | null;
  readonly add: (file: File) => Promise<void>;
  readonly remove: () => Promise<void>;
}

const pollMs = 700;

/** The labels of a scan, and the upload of new ones. */
export function useLabels(set: DataSet): LabelsTask {
  const app = useApp();
  const [labels, setLabels] = useState(set.labels);
  const [phase, setPhase] = useState<LabelsPhase | null>(set.labels?.placing ? "placing" : null);
  const [sent, setSent] = useState(0);
  const [stalled, setStalled] = useState<StallReason | null>(null);
  const [fault, setFault] = useState("");
  const [failedFile, setFailedFile] = useState<File | null>(null);
  const running = useRef<LabelUpload | null>(null);
  const failed = (thrown: unknown) => {
    setFault(faultOf(thrown) ?? app.explain(thrown));
    setPhase(null);
  };
  const learned = (now: DataSet["labels"]) => {
    setLabels(now);
    if (!now?.placing) setPhase(null);
  };
  useEffect(() => () => running.current?.stop(), []);
  usePlacing(app, set.id, phase === "placing", learned, failed);

  const add = async (file: File) => {
    running.current?.stop();
    setFault("");
    setFailedFile(null);
    setSent(0);
    setStalled(null);
    setPhase("reading");
    try {
      const bundle = makeBundle([await cleanLabelFile(file)]);
      setPhase("sending");
      running.current = new LabelUpload(app.api, local, set.id, bundle, {
        announced: setLabels,
        progress: (part) => {
          setStalled(null);
          setSent(part);
        },
        stalled: setStalled,
        done: () => setPhase("placing"),
        failed: (thrown) => {
          setFailedFile(file);
          failed(thrown);
        },
      });
    } catch (thrown) {
      failed(thrown);
    }
  };
  const remove = async () => {
    setFault("");
    try {
      await app.api.removeLabels(set.id);
      learned((await app.api.dataSet(set.id)).labels);
    } catch (thrown) {
      failed(thrown);
    }
  };
  const again = failedFile && (() => add(failedFile));
  return { labels, phase, sent, stalled, fault, again, add, remove };
}

/** Polls while the server reads a file of labels. */
function usePlacing(
  app: AppState,
  id: string,
  on: boolean,
  learned: (labels: DataSet["labels"]) => void,
  failed: (thrown: unknown) => void,
): void {
  const events = useLatest({ learned, failed });
  useEffect(() => {
    if (!on) return;
    let left = false;
    let timer: ReturnType<typeof setTimeout>;
    const ask = () => {
      app.api.dataSet(id).then(
        ({ labels }) => {
          if (left) return;
          if (labels?.placing) timer = setTimeout(ask, pollMs);
          events.current.learned(labels);
        },
        (thrown: unknown) => {
          if (!left) events.current.failed(thrown);
        },
      );
    };
    ask();
    return () => {
      left = true;
      clearTimeout(timer);
    };
  }, [app, id, on, events]);
}

function faultOf(thrown: unknown): string | null {
  if (thrown instanceof LabelFileError) return t.labels.faults[thrown.fault];
  if (thrown instanceof LabelUploadError) return t.labels.faults.rejected;
  if (!(thrown instanceof ApiProblem)) return null;
  switch (thrown.kind) {
    case "over-quota":
      return t.labels.faults.over_quota;
    case "upload-too-large":
      return t.labels.faults.too_large;
    case "conflict":
      return t.labels.faults.busy;
    default:
      return null;
  }
}
