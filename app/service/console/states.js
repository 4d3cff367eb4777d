// The states of a job.
export const STATES = ["queued", "running", "paused", "cancelling", "succeeded", "failed", "cancelled"];
export const FINAL = ["succeeded", "failed", "cancelled"];
