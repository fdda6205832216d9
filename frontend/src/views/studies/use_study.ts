import { useCallback, useEffect, useRef, useState } from "preact/hooks";
import { ApiProblem } from "../../api/client";
import type { Study } from "../../api/studies";
import { tab } from "../../storage";
import { findingsOf } from "../../studies/check";
import { templates, type Definition, type Template } from "../../studies/definition";
import { newDefinition } from "../../studies/templates";
import { t } from "../../texts";
import { navigate } from "../router";
import { UserError, useApp } from "../state";

const draftKey = (id: string): string => `diaphane.study.draft.${id}`;
const templateOf = (id: string): Template | null => templates.find((one) => one === id) ?? null;

/** Changes that this tab keeps until they are saved, and the version of the study that they belong to. */
interface Draft {
  readonly etag: string;
  readonly definition: Definition;
}

function keptDraft(id: string): Draft | null {
  try {
    const kept = JSON.parse(tab.getItem(draftKey(id)) ?? "null") as Partial<Draft> | null;
    return kept?.definition && typeof kept.etag === "string" ? { etag: kept.etag, definition: kept.definition } : null;
  } catch {
    return null;
  }
}

const keep = (id: string, etag: string, definition: Definition) =>
  tab.setItem(draftKey(id), JSON.stringify({ etag, definition } satisfies Draft));

/** What the page shows of a study: the saved version, or changes that this tab has kept. */
function useDraft(studyId: string) {
  const app = useApp();
  const [study, setStudy] = useState<Study | null>(null);
  const [definition, setDefinition] = useState<Definition | null>(null);
  const [dirty, setDirty] = useState(false);
  /** Whether the unsaved changes belong to an earlier version than the server's. */
  const [stale, setStale] = useState(false);
  /** What the page shows, also for a save that began earlier. */
  const latest = useRef<Definition | null>(null);
  const template = templateOf(studyId);
  const show = (next: Definition | null, isDirty: boolean) => {
    latest.current = next;
    setDefinition(next);
    setDirty(isDirty);
  };
  const load = useCallback(async () => {
    const kept = keptDraft(studyId);
    const saved = template ? null : await app.api.studies.get(studyId);
    const isFrozen = saved !== null && saved.joined > 0;
    const first = saved?.definition ?? (template ? await newDefinition(template, Date.now()) : null);
    setStudy(saved);
    show(isFrozen ? first : (kept?.definition ?? first), !isFrozen && (kept !== null || template !== null));
    setStale(!isFrozen && saved !== null && kept !== null && kept.etag !== saved.etag);
  }, [app, studyId, template]);
  const change = (next: Definition) => {
    keep(studyId, stale ? "" : (study?.etag ?? ""), next);
    show(next, true);
  };
  return { app, study, setStudy, definition, dirty, stale, setStale, latest, template, show, load, change };
}

/**
 * A study that is being composed. `studyId` is a template before the study is saved for the first time. Unsaved changes
 * survive a reload.
 */
export function useStudy(studyId: string) {
  const draft = useDraft(studyId);
  const { app, study, setStudy, definition, dirty, stale, setStale, latest, template, show, load, change } = draft;
  const [fault, setFault] = useState("");
  /** The study that is shown already when the page gets its address, after it was saved for the first time. */
  const created = useRef("");
  useEffect(() => {
    if (created.current === studyId) return;
    load().catch((thrown: unknown) => setFault(app.explain(thrown)));
  }, [app, load, studyId]);
  /** What is wrong with a save. If the study was changed elsewhere, the page learns the newest version. */
  const refused = async (before: Study, thrown: unknown): Promise<unknown> => {
    if (!(thrown instanceof ApiProblem) || ![409, 412].includes(thrown.status)) return thrown;
    const now = await app.api.studies.get(before.id);
    if (now.joined === 0) {
      setStudy(now);
      setStale(true);
      return new UserError(t.studies.changedElsewhere);
    }
    tab.removeItem(draftKey(studyId));
    await load();
    return new UserError(t.studies.frozen);
  };
  /** Saves the study. Resolves with the saved one. */
  const save = async (): Promise<Study> => {
    if (!definition) throw new UserError(t.problems.internal);
    if (study && !dirty) return study;
    const saved = await (study
      ? app.api.studies.save(study, definition).catch(async (thrown: unknown) => {
          throw await refused(study, thrown);
        })
      : app.api.studies.create(definition));
    tab.removeItem(draftKey(studyId));
    setStudy(saved);
    setStale(false);
    created.current = saved.id;
    if (latest.current === definition) show(saved.definition, false);
    else if (latest.current) keep(saved.id, saved.etag, latest.current); // typed while it was saved
    if (template) navigate(`/studies/${saved.id}`, true);
    return saved;
  };
  const discard = () => {
    tab.removeItem(draftKey(studyId));
    if (template) navigate("/studies");
    else void load().catch((thrown: unknown) => setFault(app.explain(thrown)));
  };
  const reload = async () => {
    if (study) setStudy(await app.api.studies.get(study.id));
  };
  const findings = definition ? findingsOf(definition, Date.now()) : [];
  return { study, definition, dirty, stale, fault, findings, change, save, discard, reload };
}

export type StudyEditing = ReturnType<typeof useStudy>;
