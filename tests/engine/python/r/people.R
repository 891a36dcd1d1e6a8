# What R makes of people.csv: every test, mean and interval of `experiment analyse`. Rscript people.R > people.json
# R 4.2.2 with nlme 3.1-162. Not run by any test: people_agreement_test.py reads the result.

here <- dirname(sub("--file=", "", grep("--file=", commandArgs(FALSE), value = TRUE)))
source(file.path(here, "json.R"))
library(nlme)
options(contrasts = c("contr.sum", "contr.poly"), digits = 17)
LIMIT <- 120

# --- The trials that count

all <- read.csv(file.path(here, "people.csv"), colClasses = c(participant = "character"), na.strings = "")
rows <- all[all$block > 0 & all$pilot == 0, ]
key <- interaction(rows$participant, rows$block, rows$haptic, rows$rotation, rows$object, drop = TRUE)
counted <- do.call(rbind, lapply(split(rows, key), function(trial) {
  done <- trial[trial$status == "done", ]
  from <- if (nrow(done) > 0) done else trial
  from[which.max(from$attempt), ]
}))
counted$participant <- factor(counted$participant, as.character(1:12))
counted$Haptic <- factor(counted$haptic, c("NoH", "UaH", "H"))
counted$Rotation <- factor(counted$rotation, c("NoR", "R"))
counted$Object <- factor(counted$object)
counted$Trial <- factor(counted$block)
is_done <- counted$status == "done"
of_done <- function(x) ifelse(is_done, x, NA)
counted$"total time" <- of_done(counted$total_time_s)
counted$"losses of contact" <- of_done(counted$losses_of_contact)
counted$"mean penetration" <- of_done(counted$mean_penetration_dm)
counted$"mean contact angle" <- of_done(counted$mean_contact_angle_deg)
counted$"losses of contact per second" <- of_done(counted$losses_of_contact / counted$total_time_s)
counted$"total time, timeouts as the limit" <-
  ifelse(counted$status == "timeout", LIMIT, counted$"total time")
paper_outcomes <- c("total time", "losses of contact", "mean penetration")
outcomes <- c(paper_outcomes, "mean contact angle", "losses of contact per second",
              "total time, timeouts as the limit")
FACTORS <- c("Haptic", "Rotation", "Object", "Trial")

# "Object x Rotation x Haptic", as the pages name effects.
effect_name <- function(term) paste(rev(term), collapse = " x ")
terms_of <- function(factors) unlist(lapply(seq_along(factors), function(k) combn(factors, k, simplify = FALSE)),
                                     recursive = FALSE)

# --- As the paper did it: type III, all trials independent

done <- droplevels(counted[is_done, ])
full <- as.formula(paste("~", paste(FACTORS, collapse = " * ")))
X <- model.matrix(full, done)
labels <- attr(terms(full), "term.labels")
Y <- as.matrix(done[paper_outcomes])
fit <- lm(Y ~ 0 + X)
error_df <- fit$df.residual
effects <- list()
for (term in terms_of(FACTORS)) {
  out <- which(vapply(strsplit(labels, ":"), setequal, NA, term))
  without <- X[, attr(X, "assign") != out]
  test <- anova(lm(Y ~ 0 + without), fit, test = "Wilks")[2, ]
  effects <- c(effects, list(list(analysis = "manova", outcome = paste(paper_outcomes, collapse = ", "),
    effect = effect_name(term), wilks_lambda = test[["Wilks"]], f = test[["approx F"]],
    df1 = test[["num Df"]], df2 = test[["den Df"]], p = test[["Pr(>F)"]], trials = nrow(done))))
  for (outcome in paper_outcomes) {
    y <- done[[outcome]]
    one <- lm(y ~ 0 + X)
    test <- anova(lm(y ~ 0 + without), one)[2, ]
    ss <- test[["Sum of Sq"]]
    effects <- c(effects, list(list(analysis = "anova", outcome = outcome, effect = effect_name(term),
      f = test[["F"]], df1 = test[["Df"]], df2 = error_df, p = test[["Pr(>F)"]],
      partial_eta2 = ss / (ss + deviance(one)), trials = nrow(done))))
  }
}

# --- Repeated measures: anova() of a multivariate model; sums of squares by aov()

# Means of the participants who have all cells of the factors.
complete <- function(table, outcome, factors) {
  there <- table[!is.na(table[[outcome]]), ]
  means <- aggregate(list(x = there[[outcome]]), there[c(rev(factors), "participant")], mean)
  cells <- prod(vapply(factors, function(f) nlevels(table[[f]]), 1L))
  people <- names(which(table(means$participant) == cells))
  droplevels(means[means$participant %in% people, ])
}

repeated <- function(means, factors, wanted) {
  idata <- unique(means[factors])
  wide <- matrix(means$x, ncol = nrow(idata), byrow = TRUE)
  fit <- lm(wide ~ 1)
  errors <- summary(aov(as.formula(paste0("x ~ ", paste(factors, collapse = " * "), " + Error(participant / (",
                                          paste(factors, collapse = " * "), "))")), means))
  ss <- lapply(errors, function(stratum) stratum[[1]][["Sum Sq"]])
  with_people <- sum(vapply(ss, function(s) s[length(s)], 0))
  lapply(Filter(wanted, terms_of(factors)), function(term) {
    M <- as.formula(paste("~", paste(term, collapse = " * ")))
    all_parts <- attr(terms(M), "term.labels")
    parts <- all_parts[-length(all_parts)]
    X <- if (length(parts)) as.formula(paste("~", paste(parts, collapse = " + "))) else ~ 1
    test <- anova(fit, M = M, X = X, idata = idata, test = "Spherical")
    stratum <- names(ss)[vapply(strsplit(sub("^Error: ", "", names(ss)), ":"), setequal, NA,
                                c("participant", term))]
    own <- ss[[stratum]][1]
    list(effect = effect_name(term), f = test[1, "F"], df1 = test[1, "num Df"], df2 = test[1, "den Df"],
         p = test[1, "Pr(>F)"], gg_epsilon = stats:::sphericity(SSD(fit), M = M, X = X, idata = idata)$GG.eps,
         gg_p = test[1, "G-G Pr"], generalized_eta2 = own / (own + with_people), participants = nrow(wide))
  })
}

primary <- function(table, outcome, analysis, factors) {
  in_conditions <- repeated(complete(table, outcome, factors), factors, function(term) TRUE)
  in_blocks <- repeated(complete(table, outcome, c(factors, "Trial")), c(factors, "Trial"),
                        function(term) "Trial" %in% term)
  lapply(c(in_conditions, in_blocks), function(e) c(list(analysis = analysis, outcome = outcome), e))
}
uah <- droplevels(counted[counted$haptic == "UaH", ])
for (outcome in outcomes) effects <- c(effects, primary(counted, outcome, "repeated measures",
                                                        c("Haptic", "Rotation", "Object")))
effects <- c(effects, primary(uah, "mean contact angle", "repeated measures, UaH", c("Rotation", "Object")))

# --- Comparisons

ends <- function(low, high, f) uniroot(f, c(low, high), tol = 1e-13, maxiter = 10000)$root

paired <- function(a, b) {
  d <- na.omit(a - b)
  n <- length(d)
  test <- t.test(d)
  t <- unname(test$statistic)
  list(difference = mean(d), half_width_95 = unname(diff(test$conf.int) / 2), t = t, df = n - 1, p = test$p.value,
       participants = n, d_z = t / sqrt(n),
       d_z_low_95 = ends(-60, 60, function(ncp) pt(t, n - 1, ncp, lower.tail = FALSE) - 0.025) / sqrt(n),
       d_z_high_95 = ends(-60, 60, function(ncp) pt(t, n - 1, ncp) - 0.025) / sqrt(n), differences = d)
}

# participant x Haptic x Rotation: means over objects; NA without all objects.
by_condition <- function(table, outcome) {
  cells <- tapply(table[[outcome]], table[c("participant", "Haptic", "Rotation", "Object")], mean, na.rm = TRUE)
  cells[is.nan(cells)] <- NA
  apply(cells, 1:3, mean)
}

comparisons <- list()
for (outcome in paper_outcomes) for (factor in FACTORS) {
  p <- Filter(function(e) e$analysis == "anova" && e$outcome == outcome && e$effect == factor, effects)[[1]]$p
  if (p >= 0.05) next
  values <- split(done[[outcome]], done[[factor]])
  mse <- deviance(lm(done[[outcome]] ~ 0 + X)) / error_df
  pairs <- combn(levels(done[[factor]]), 2, simplify = FALSE)
  for (pair in pairs) {
    a <- values[[pair[1]]]
    b <- values[[pair[2]]]
    error <- sqrt(mse * (1 / length(a) + 1 / length(b)))
    t <- (mean(a) - mean(b)) / error
    comparisons <- c(comparisons, list(list(analysis = "plsd", outcome = outcome, family = factor,
      pair = paste(pair, collapse = " - "), difference = mean(a) - mean(b), t = t, df = error_df,
      p = 2 * pt(-abs(t), error_df), least_significant_difference = qt(0.975, error_df) * error)))
  }
}
family <- function(analysis, outcome, name, pairs) {
  holm <- p.adjust(vapply(pairs, function(x) x$p, 0), "holm")
  Map(function(pair, test, p) c(list(analysis = analysis, outcome = outcome, family = name, pair = pair),
                                test[names(test) != "differences"], list(p_holm = p)), names(pairs), pairs, holm)
}
paired_comparisons <- function(table, outcome, analysis) {
  x <- by_condition(table, outcome)
  haptic <- dimnames(x)$Haptic
  found <- list()
  if (length(haptic) > 1) {
    of <- apply(x, 1:2, mean)
    pairs <- combn(haptic, 2, simplify = FALSE)
    tests <- lapply(pairs, function(p) paired(of[, p[2]], of[, p[1]]))
    names(tests) <- vapply(pairs, function(p) paste(p[2], "-", p[1]), "")
    found <- family(analysis, outcome, "levels of Haptic", tests)
  }
  tests <- lapply(haptic, function(h) paired(x[, h, "R"], x[, h, "NoR"]))
  names(tests) <- paste("R - NoR in", haptic)
  unname(c(found, family(analysis, outcome, "R - NoR within each level of Haptic", tests)))
}
for (outcome in outcomes) comparisons <- c(comparisons, paired_comparisons(counted, outcome, "paired t"))
comparisons <- c(comparisons, paired_comparisons(uah, "mean contact angle", "paired t, UaH"))

# --- Means: of trials; of participants with the intervals of Cousineau (2005) and Morey (2008)

cousineau_morey <- function(values) {
  n <- nrow(values)
  k <- ncol(values)
  normalised <- values - rowMeans(values) + mean(values)
  qt(0.975, n - 1) * apply(normalised, 2, sd) * sqrt(k / (k - 1)) / sqrt(n)
}
means <- list()
mean_rows <- function(of, outcome, values, haptic, rotation) {
  values <- values[complete.cases(values), ]
  lapply(seq_len(ncol(values)), function(i) list(of = of, outcome = outcome, haptic = haptic[i],
    rotation = rotation[i], object = "all", n = nrow(values), mean = mean(values[, i]),
    half_width_95 = unname(cousineau_morey(values)[i])))
}
for (outcome in outcomes) {
  x <- by_condition(counted, outcome)
  h <- dimnames(x)$Haptic
  r <- dimnames(x)$Rotation
  means <- c(means, mean_rows("participants", outcome, apply(x, 1:2, mean), h, rep("all", 3)),
             mean_rows("participants", outcome, apply(x, c(1, 3), mean), rep("all", 2), r),
             mean_rows("participants", outcome, matrix(aperm(x, c(1, 3, 2)), nrow(x)), rep(h, each = 2), rep(r, 3)))
  for (level in c("all", h)) for (turn in c("all", r)) for (thing in c("all", levels(counted$Object))) {
    if (thing != "all" && (level != "all" || turn != "all")) next
    at <- (level == "all" | counted$Haptic == level) & (turn == "all" | counted$Rotation == turn) &
      (thing == "all" | counted$Object == thing)
    y <- na.omit(counted[[outcome]][at])
    means <- c(means, list(list(of = "trials", outcome = outcome, haptic = level, rotation = turn, object = thing,
                                n = length(y), mean = mean(y), sd = sd(y))))
  }
}
x <- by_condition(uah, "mean contact angle")
means <- c(means, mean_rows("participants, UaH", "mean contact angle", x[, 1, ], rep("UaH", 2), dimnames(x)$Rotation))

# --- Missing trials

missing_row <- function(haptic, rotation, object, at) {
  here <- counted[at, ]
  count <- function(status) sum(here$status == status)
  ended <- count("done") + count("timeout") + count("fault")
  suppressWarnings(wilson <- prop.test(count("timeout"), ended, correct = FALSE)$conf.int)
  list(haptic = haptic, rotation = rotation, object = object, done = count("done"), timeouts = count("timeout"),
       faults = count("fault"), aborted = count("aborted"), skipped = count("skipped"),
       absent = 24 * if (haptic == "all") 12 else 1, timeout_share = count("timeout") / ended,
       timeout_share_low = wilson[1], timeout_share_high = wilson[2])
}
missing <- list(missing_row("all", "all", "all", rep(TRUE, nrow(counted))))
for (h in levels(counted$Haptic)) for (r in levels(counted$Rotation)) for (o in levels(counted$Object)) {
  missing <- c(missing, list(missing_row(h, r, o, counted$Haptic == h & counted$Rotation == r & counted$Object == o)))
}
missing <- lapply(missing, function(row) {  # so far all that were planned: 12 people, 2 blocks
  row$absent <- row$absent - row$done - row$timeouts - row$faults - row$aborted - row$skipped
  row
})

# --- Verdicts: effects with intervals that hold together (Bonferroni), beside those of the paper

PAPER <- list("total time" = list(NoH = 29, UaH = 27.5, H = 25, NoR = 25.14, R = 29.15, f_haptic = 12.141, f_rotation = 29.674),
              "losses of contact" = list(NoH = 24, UaH = 22, H = 21, NoR = 22, R = 23, f_haptic = 19.139, f_rotation = 22.389),
              "mean penetration" = list(NoH = 0.101, UaH = 0.068, H = 0.031))
verdicts <- list()
verdict_rows <- function(finding, tests, margin = NULL) {
  k <- length(tests)
  p <- vapply(tests, function(x) {
    if (is.null(margin)) return(x$p)
    max(t.test(x$differences, mu = -margin, alternative = "greater")$p.value,
        t.test(x$differences, mu = margin, alternative = "less")$p.value)
  }, 0)
  Map(function(name, x, p, holm) {
    interval <- t.test(x$differences, conf.level = 1 - 0.05 / k)$conf.int
    list(finding = finding, comparison = name, difference = x$difference, low_95 = interval[1], high_95 = interval[2],
         p = p, p_holm = holm, participants = x$participants)
  }, names(tests), tests, p, p.adjust(p, "holm"))
}
order_of <- function(pairs, x, name = "%s - %s") {
  tests <- lapply(pairs, function(p) paired(x[, p[1]], x[, p[2]]))
  names(tests) <- vapply(pairs, function(p) sprintf(name, p[1], p[2]), "")
  tests
}
HAPTIC <- c("NoH", "UaH", "H")
ascending <- list(c("UaH", "H"), c("NoH", "H"), c("NoH", "UaH"))
MARGINS <- c("total time" = 0.75, "losses of contact" = 0.5, "mean penetration" = 0.0165)
for (outcome in paper_outcomes) {
  x <- by_condition(counted, outcome)
  verdicts <- c(verdicts, verdict_rows(paste0(outcome, ", Haptic"), order_of(ascending, apply(x, 1:2, mean))))
  margin <- MARGINS[[outcome]]
  of_rotation <- order_of(list(c("R", "NoR")), apply(x, c(1, 3), mean))
  if (outcome == "mean penetration") {
    verdicts <- c(verdicts, verdict_rows(paste0(outcome, ", Rotation"), of_rotation, margin))
  } else {
    verdicts <- c(verdicts, verdict_rows(paste0(outcome, ", Rotation"), of_rotation))
    turned <- x[, , "R"] - x[, , "NoR"]
    pairs <- list(c("UaH", "NoH"), c("H", "NoH"), c("H", "UaH"))
    verdicts <- c(verdicts, verdict_rows(paste0(outcome, ", Rotation x Haptic"),
                                         order_of(pairs, turned, "R - NoR in %s, less in %s"), margin))
  }
}
x <- by_condition(uah, "mean contact angle")
verdicts <- c(verdicts, verdict_rows("mean contact angle, Rotation", order_of(list(c("NoR", "R")), x[, 1, ])))

# --- The parts of the variance, and losses as counts

variances <- lapply(paper_outcomes, function(outcome) {
  d <- done
  d$condition <- interaction(d$Haptic, d$Rotation, drop = TRUE)
  d$cell <- interaction(d$Haptic, d$Rotation, d$Object, d$Trial, drop = TRUE)
  scale <- sd(d[[outcome]])
  d$y <- d[[outcome]] / scale
  m <- lme(y ~ 0 + cell, random = ~ 1 | participant / condition, data = d,
           control = lmeControl(niterEM = 500, opt = "nlminb", msMaxIter = 1000, tolerance = 1e-12, msTol = 1e-14))
  v <- suppressWarnings(as.numeric(VarCorr(m)[, "StdDev"]))
  v <- scale * v[!is.na(v)]
  list(outcome = outcome, sd_participants = v[1], sd_participant_condition = v[2], sd_trials = v[3],
       share_of_participants = sum(v[1:2]^2) / sum(v^2), trials = nrow(d), participants = nlevels(d$participant))
})

rates <- function(base) {
  d <- done
  d$haptic <- relevel(factor(d$haptic, HAPTIC), base)
  d$rotation <- factor(d$rotation, c("NoR", "R"))
  m <- glm(losses_of_contact ~ participant + haptic + rotation + object + Trial, family = quasipoisson,
           offset = log(total_time_s), data = d, contrasts = list(haptic = "contr.treatment", rotation = "contr.treatment"),
           control = glm.control(epsilon = 1e-16, maxit = 100))
  list(table = summary(m)$coefficients, df = m$df.residual, dispersion = summary(m)$dispersion, trials = nrow(d))
}
rate <- function(model, name, factor, pair) {
  s <- model$table[name, ]
  half <- qt(0.975, model$df) * s[2]
  list(factor = factor, pair = pair, ratio = exp(s[[1]]), low_95 = exp(s[[1]] - half)[[1]],
       high_95 = exp(s[[1]] + half)[[1]], p = s[[4]], df = model$df, dispersion = model$dispersion, trials = model$trials)
}
of_noh <- rates("NoH")
loss_rates <- list(rate(of_noh, "hapticUaH", "Haptic", "UaH / NoH"), rate(of_noh, "hapticH", "Haptic", "H / NoH"),
                   rate(rates("UaH"), "hapticH", "Haptic", "H / UaH"), rate(of_noh, "rotationR", "Rotation", "R / NoR"))

# --- A line for each row

cat(gsub("}, {", "},\n{", json(list(r = R.version.string, nlme = as.character(packageVersion("nlme")),
  tables = list(effects = effects, comparisons = comparisons, means = means, missing_trials = missing,
                verdicts = unname(verdicts), variances = variances, loss_rates = loss_rates)), 12), fixed = TRUE), "\n", sep = "")
