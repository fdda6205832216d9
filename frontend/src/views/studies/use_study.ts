import { useCallback, useEffect, useRef, useState } from "preact/hooks";
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

/** Changes that this tab keeps until they are saved. */
function keptDraft(id: string): Definition | null {
  try {
    return JSON.parse(tab.getItem(draftKey(id)) ?? "null") as Definition | null;
  } catch {
    return null;
  }
}

/**
 * A study that is being composed. `studyId` is a template before the study is saved for the first time. Unsaved changes
 * survive a reload.
 */
export function useStudy(studyId: string) {
  const app = useApp();
  const [study, setStudy] = useState<Study | null>(null);
  const [definition, setDefinition] = useState<Definition | null>(null);
  const [dirty, setDirty] = useState(false);
  const [fault, setFault] = useState("");
  /** The study that is shown already when the page gets its address, after it was saved for the first time. */
  const created = useRef("");
  const template = templateOf(studyId);
  const load = useCallback(async () => {
    const kept = keptDraft(studyId);
    const saved = template ? null : await app.api.studies.get(studyId);
    const isFrozen = saved !== null && saved.joined > 0;
    setStudy(saved);
    setDirty(!isFrozen && (kept !== null || template !== null));
    const first = saved?.definition ?? (template ? await newDefinition(template, Date.now()) : null);
    setDefinition(isFrozen ? first : (kept ?? first));
  }, [app, studyId, template]);
  useEffect(() => {
    if (created.current === studyId) return;
    load().catch((thrown: unknown) => setFault(app.explain(thrown)));
  }, [app, load, studyId]);
  const change = (next: Definition) => {
    tab.setItem(draftKey(studyId), JSON.stringify(next));
    setDefinition(next);
    setDirty(true);
  };
  /** Saves the study. Resolves with the saved one. */
  const save = async (): Promise<Study> => {
    if (!definition) throw new UserError(t.problems.internal);
    if (study && !dirty) return study;
    const saved = study ? await app.api.studies.save(study, definition) : await app.api.studies.create(definition);
    tab.removeItem(draftKey(studyId));
    setStudy(saved);
    setDefinition(saved.definition);
    setDirty(false);
    created.current = saved.id;
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
  return { study, definition, dirty, fault, findings, change, save, discard, reload };
}

export type StudyEditing = ReturnType<typeof useStudy>;
