import { useEffect, useRef, useState } from "preact/hooks";
import { ApiProblem } from "../../api/client";
import type { DataSet } from "../../api/types";
import { startUpload, type RunningUpload } from "../../api/upload";
import { makeBundle } from "../../scan/bundle";
import { cleanLabelFile, LabelFileError } from "../../scan/label_file";
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
  readonly fault: string;
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
  const [fault, setFault] = useState("");
  const running = useRef<RunningUpload | null>(null);
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
    setFault("");
    setSent(0);
    setPhase("reading");
    try {
      const bundle = makeBundle([await cleanLabelFile(file)]);
      const announced = await app.api.addLabels(set.id, bundle.size);
      setLabels(announced.data_set.labels);
      setPhase("sending");
      const done = () => setPhase("placing");
      running.current = send(app, bundle, announced.upload_url, { progress: setSent, done, failed });
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
  return { labels, phase, sent, fault, add, remove };
}

interface SendEvents {
  readonly progress: (part: number) => void;
  readonly done: () => void;
  readonly failed: (thrown: unknown) => void;
}

function send(app: AppState, bundle: Blob, url: string, events: SendEvents): RunningUpload {
  return startUpload(bundle, url, () => app.api.csrfToken, {
    progress: (bytes, total) => events.progress(bytes / total),
    stalled: () => undefined, // it resumes automatically, and the bar shows its progress
    end: ({ kind }) => (kind === "done" ? events.done() : events.failed(new LabelUploadError())),
  });
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

/** Thrown if the server has rejected an upload permanently. */
class LabelUploadError extends Error {}

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
