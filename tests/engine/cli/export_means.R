# What R reads from an export: Rscript export_means.R DATASET prints every mean per condition as CSV, as
# `experiment analyse` names them. export_command_test.py runs it where Rscript is installed. Base R only.

folder <- commandArgs(TRUE)[1]
files <- sort(list.files(file.path(folder, "data"), "^subject-[0-9]+_task-contour_data[.]csv$", full.names = TRUE))
all <- do.call(rbind, lapply(files, read.csv, na.strings = c("", "NA"), colClasses = c(participant = "character")))
rows <- all[all$block > 0 & all$pilot == 0, ]
trial <- paste(rows$participant, rows$block, rows$haptic, rows$rotation, rows$object)
counted <- do.call(rbind, lapply(split(rows, trial), function(attempts) {
  done <- attempts[attempts$status == "done", ]
  from <- if (nrow(done) > 0) done else attempts
  from[which.max(from$attempt), ]
}))
is_done <- counted$status == "done"
of_done <- function(x) ifelse(is_done, x, NA)
depth_dm <- if (is.null(counted$mean_penetration_dm)) 10 * counted$mean_penetration_m else counted$mean_penetration_dm
outcomes <- list(
  "total time" = of_done(counted$total_time_s),
  "losses of contact" = of_done(counted$losses_of_contact),
  "mean penetration" = of_done(depth_dm),
  "mean contact angle" = of_done(counted$mean_contact_angle_deg),
  "losses of contact per second" = of_done(counted$losses_of_contact / counted$total_time_s),
  "total time, timeouts as the limit" = ifelse(counted$status == "timeout", 120, of_done(counted$total_time_s)))
haptic <- c("NoH", "UaH", "H")
rotation <- c("NoR", "R")
object <- sort(unique(counted$object))

tell <- function(of, outcome, haptic, rotation, object, values) {
  writeLines(sprintf("%s;%s;%s;%s;%s;%d;%.17g", of, outcome, haptic, rotation, object, length(values), mean(values)))
}
complete <- function(x) x[complete.cases(x), , drop = FALSE]
for (outcome in names(outcomes)) {
  y <- outcomes[[outcome]]
  for (h in c("all", haptic)) for (r in c("all", rotation)) for (o in c("all", object)) {
    if (o != "all" && (h != "all" || r != "all")) next
    at <- (h == "all" | counted$haptic == h) & (r == "all" | counted$rotation == r) & (o == "all" | counted$object == o)
    tell("trials", outcome, h, r, o, y[at & !is.na(y)])
  }
  cells <- tapply(y, list(counted$participant, factor(counted$haptic, haptic), factor(counted$rotation, rotation),
                          counted$object), mean, na.rm = TRUE)
  x <- apply(cells, 1:3, mean)  # over the objects; no number without all of them
  of_haptic <- complete(apply(x, 1:2, mean))
  for (h in haptic) tell("participants", outcome, h, "all", "all", of_haptic[, h])
  of_rotation <- complete(apply(x, c(1, 3), mean))
  for (r in rotation) tell("participants", outcome, "all", r, "all", of_rotation[, r])
  of_both <- complete(matrix(x, nrow(x)))
  for (h in haptic) for (r in rotation) {
    column <- match(h, haptic) + length(haptic) * (match(r, rotation) - 1)
    tell("participants", outcome, h, r, "all", of_both[, column])
  }
  if (outcome != "mean contact angle") next
  of_uah <- complete(x[, "UaH", ])
  for (r in rotation) tell("participants, UaH", outcome, "UaH", r, "all", of_uah[, r])
}
