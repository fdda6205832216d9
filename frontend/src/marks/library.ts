import { batch, effect, signal } from "@preact/signals";
import type { AnnotationChange, AnnotationsApi, AnnotationSet } from "../api/annotations";
import { ApiProblem } from "../api/client";
import { annotationsFromJson, annotationsToJson, type Annotations } from "../protocol/mark_messages";
import { isWhole } from "../slices/measure";
import type { Slices } from "../slices/model";
import type { After } from "../live/paced";
import { withSet } from "./mark";
import type { Marks } from "./marks";
import { merged } from "./merge";

/** The marks and measurements of a preset or a link. They belong to no saved set. */
export const viewSet = "view";
export const saveAfterMs = 1000;

export interface LibraryParts {
  readonly api: Pick<AnnotationsApi, "add" | "change" | "remove">;
  readonly list: () => Promise<readonly AnnotationSet[]>;
  readonly dataSetId: string;
  readonly marks: Marks;
  readonly slices: Pick<Slices, "measures" | "following">;
  readonly after: After;
  /** Whether this user may save marks with the scan, and whether they may share them. */
  readonly saves: boolean;
  readonly shares: boolean;
  /**
   * What the tab remembers: sets with changes that the server may not have, and hidden sets of
   * others.
   */
  readonly memory: { unsavedSets: readonly string[]; hiddenSets: readonly string[] };
}

const empty: Annotations = { marks: [], measures: [] };

/** Returns the marks and the measurements that belong to a set, or to none. */
export function annotationsOf(
  parts: Pick<LibraryParts, "marks" | "slices">,
  isIn: (set?: string) => boolean,
): Annotations {
  return {
    marks: parts.marks.items.value.filter(({ set }) => isIn(set)),
    measures: parts.slices.measures.value.filter((measure) => isWhole(measure) && isIn(measure.set)),
  };
}

/** Shows marks and measurements as those of a set, instead of those that it had. */
export function showSet(
  { marks, slices }: Pick<LibraryParts, "marks" | "slices">,
  set: string,
  content: Annotations,
): void {
  batch(() => {
    marks.show(set, content.marks);
    if (slices.following.value) return; // the measurements are the presenter's
    const others = slices.measures.value.filter((measure) => measure.set !== set);
    slices.measures.value = [...others, ...content.measures.map((measure) => ({ ...measure, set }))];
  });
}

/**
 * The sets of marks and measurements that are saved with a scan. Changes to shown sets are saved
 * automatically.
 */
export class MarkLibrary {
  /** The sets, or null until they are loaded. */
  readonly sets = signal<readonly AnnotationSet[] | null>(null);
  /** The IDs of the sets that are shown. */
  readonly visible = signal<ReadonlySet<string>>(new Set());
  /** Whether the last change could not be saved. */
  readonly failed = signal(false);
  private readonly stored = new Map<string, string>();
  private readonly stopWatching: () => void;
  private cancel: (() => void) | null = null;

  constructor(private readonly parts: LibraryParts) {
    this.stopWatching = effect(() => this.watch());
  }

  get saves(): boolean {
    return this.parts.saves;
  }

  get shares(): boolean {
    return this.parts.shares;
  }

  async load(): Promise<void> {
    const sets = await this.parts.list();
    batch(() => {
      this.sets.value = sets;
      this.forgetMissing(sets);
      for (const set of sets) this.begin(set);
      this.lock();
    });
  }

  /** Saves the marks and measurements that belong to no set as a new set. */
  async add(name: string): Promise<void> {
    const { api, dataSetId, marks, slices } = this.parts;
    const content = annotationsToJson(this.unsaved());
    const set = await api.add(dataSetId, name, content);
    batch(() => {
      this.stored.set(set.id, JSON.stringify(content));
      this.visible.value = new Set([...this.visible.value, set.id]);
      for (const from of [undefined, viewSet]) marks.retag(from, set.id);
      slices.measures.value = slices.measures.value.map((measure) =>
        this.isUnsaved(measure.set) ? { ...measure, set: set.id } : measure,
      );
      this.sets.value = [...(this.sets.value ?? []), set];
    });
  }

  unsaved(): Annotations {
    return annotationsOf(this.parts, (set) => this.isUnsaved(set));
  }

  /** Shows or hides a set. The server remembers the choice for a set of this user. */
  async setVisible(set: AnnotationSet, on: boolean): Promise<void> {
    if (!on) await this.save();
    if (this.changes().some(([one]) => one.id === set.id)) return; // hiding it would lose them
    batch(() => {
      if (on) this.show(set);
      else this.hide(set.id);
    });
    const { memory } = this.parts;
    if (set.mine) await this.change(set, { shown: on });
    else memory.hiddenSets = [...memory.hiddenSets.filter((one) => one !== set.id), ...(on ? [] : [set.id])];
  }

  async change(set: AnnotationSet, what: AnnotationChange): Promise<void> {
    const changed = await this.parts.api.change(this.parts.dataSetId, set.id, what);
    this.sets.value = (this.sets.value ?? []).map((one) => (one.id === set.id ? changed : one));
  }

  async remove(set: AnnotationSet): Promise<void> {
    await this.parts.api.remove(this.parts.dataSetId, set.id);
    batch(() => {
      this.hide(set.id);
      this.sets.value = (this.sets.value ?? []).filter((one) => one.id !== set.id);
    });
  }

  /** Saves the changes to those of the user's own sets that are shown. */
  async save(): Promise<void> {
    this.cancel?.();
    this.cancel = null;
    let hasFailed = false;
    for (const [set, content] of this.changes()) {
      try {
        await this.change(set, { content, revision: set.revision });
        this.stored.set(set.id, JSON.stringify(content));
      } catch (thrown) {
        const isStale = thrown instanceof ApiProblem && thrown.status === 412;
        // Merged content is a change of its own, which is saved next.
        if (!isStale || !(await this.merge(set).catch(() => false))) hasFailed = true;
      }
    }
    this.failed.value = hasFailed;
    this.noteUnsaved();
  }

  /** Merges what another window has saved meanwhile. Returns false if the set no longer exists. */
  private async merge({ id }: AnnotationSet): Promise<boolean> {
    const sets = await this.parts.list();
    const theirs = sets.find((one) => one.id === id);
    if (!theirs) return false;
    const base = annotationsFromJson(JSON.parse(this.stored.get(id) ?? "{}")) ?? empty;
    const now = annotationsOf(this.parts, (set) => set === id);
    const mine = annotationsFromJson(annotationsToJson(now)) ?? empty; // with the same rounding as the base
    const content = annotationsFromJson(theirs.content) ?? empty;
    batch(() => {
      this.stored.set(id, JSON.stringify(annotationsToJson(content)));
      this.sets.value = (this.sets.value ?? []).map((one) => (one.id === id ? theirs : one));
      showSet(this.parts, id, merged(base, mine, content));
    });
    return true;
  }

  stop(): void {
    this.stopWatching();
    // Once more for what the first attempt merged, because nothing watches for it any longer.
    void this.save().then(() => (this.changes().length > 0 ? this.save() : undefined));
  }

  private isUnsaved(set: string | undefined): boolean {
    return set === undefined || set === viewSet;
  }

  /**
   * Shows or hides a set when it is loaded. A set with changes that the server may not have keeps
   * the content that survived the reload.
   */
  private begin(set: AnnotationSet): void {
    const { memory } = this.parts;
    const content = annotationsFromJson(set.content) ?? empty;
    this.stored.set(set.id, JSON.stringify(annotationsToJson(content)));
    const isUnsaved = set.mine && memory.unsavedSets.includes(set.id);
    const isShown = set.mine ? set.shown : !memory.hiddenSets.includes(set.id);
    if (isUnsaved) this.visible.value = new Set([...this.visible.value, set.id]);
    else if (isShown) this.show(set);
    else this.hide(set.id);
  }

  private show(set: AnnotationSet): void {
    showSet(this.parts, set.id, annotationsFromJson(set.content) ?? empty);
    this.visible.value = new Set([...this.visible.value, set.id]);
  }

  private hide(id: string): void {
    const { marks, slices } = this.parts;
    this.visible.value = new Set([...this.visible.value].filter((one) => one !== id));
    marks.hide(id);
    if (!slices.following.value) slices.measures.value = slices.measures.value.filter(({ set }) => set !== id);
  }

  /** Turns marks and measurements of sets that were deleted elsewhere into unsaved ones. */
  private forgetMissing(sets: readonly AnnotationSet[]): void {
    const { marks, slices } = this.parts;
    const isGone = (set?: string) => !this.isUnsaved(set) && !sets.some(({ id }) => id === set);
    for (const set of new Set(marks.items.value.map((mark) => mark.set))) if (isGone(set)) marks.retag(set, undefined);
    slices.measures.value = slices.measures.value.map((measure) => (isGone(measure.set) ? withSet(measure) : measure));
  }

  /** Locks the sets of others, because only their author can change them. */
  private lock(): void {
    this.parts.marks.locked.value = new Set((this.sets.value ?? []).filter(({ mine }) => !mine).map(({ id }) => id));
  }

  /**
   * Returns the shown sets of this user that differ from what the server has, with their content.
   */
  private changes(): readonly (readonly [AnnotationSet, unknown])[] {
    if (this.parts.slices.following.value) return []; // the measurements are the presenter's
    return (this.sets.value ?? []).flatMap((set) => {
      if (!set.mine || !this.visible.value.has(set.id)) return [];
      const content = annotationsToJson(annotationsOf(this.parts, (one) => one === set.id));
      return JSON.stringify(content) === this.stored.get(set.id) ? [] : [[set, content] as const];
    });
  }

  private noteUnsaved(): void {
    this.parts.memory.unsavedSets = this.changes().map(([{ id }]) => id);
  }

  private watch(): void {
    if (this.changes().length === 0) return;
    this.noteUnsaved();
    this.cancel?.();
    this.cancel = this.parts.after(saveAfterMs, () => void this.save());
  }
}
