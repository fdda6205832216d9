import type { Audience, Participant } from "../protocol/messages";

/** What this page may do in a live session. Alone, or before anything is known, one presents. */
export interface Role {
  readonly you: string;
  readonly people: readonly Participant[];
  readonly others: number;
  readonly presents: boolean;
  /** Somebody else presents. */
  readonly follows: boolean;
  readonly freeCamera: boolean;
  /** By a link into somebody's session: what is cut away is not this viewer's to change. */
  readonly guest: boolean;
  /** Nothing while the presenter is away. */
  readonly presenter: Participant | null;
}

export function roleOf(audience: Audience | null): Role {
  const people = audience?.participants ?? [];
  const you = audience?.you ?? "";
  const presents = audience === null || audience.presenter === you;
  return {
    you,
    people,
    others: people.filter(({ id }) => id !== you).length,
    presents,
    follows: !presents,
    freeCamera: people.find(({ id }) => id === you)?.freeCamera ?? false,
    guest: people.some(({ id, owner }) => id === you && !owner),
    presenter: people.find(({ presenter }) => presenter) ?? null,
  };
}
