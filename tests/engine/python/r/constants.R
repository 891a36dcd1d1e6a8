# What R computes for the tables in this folder and two public data sets: Rscript constants.R > constants.json
# R 4.2.2 with nlme 3.1-162. Not run by any test: agreement_with_r_test.py reads the result.

here <- dirname(sub("--file=", "", grep("--file=", commandArgs(FALSE), value = TRUE)))
source(file.path(here, "json.R"))
library(nlme)
options(contrasts = c("contr.sum", "contr.poly"), digits = 17)

in_order <- function(x) factor(x, levels = unique(x))

# --- Data

public <- function(name) read.csv(file.path(here, "..", "data", name))
trials <- function(name) {
  table <- read.csv(file.path(here, name))
  for (column in c("person", "haptic", "rotation", "object", "block")) table[[column]] <- in_order(table[[column]])
  table
}
balanced <- trials("trials_balanced.csv")
unbalanced <- trials("trials_unbalanced.csv")
rm2 <- public("rm_anova2.csv")
rm2 <- rm2[order(rm2$Subject), ]
rm2[c("Subject", "Time", "Metric")] <- lapply(rm2[c("Subject", "Time", "Metric")], in_order)
warp <- public("warpbreaks.csv")[-c(1, 2, 30), ]
warp[c("wool", "tension")] <- lapply(warp[c("wool", "tension")], in_order)

# --- Repeated measures: Greenhouse-Geisser by anova() of a multivariate model; eta squared by aov()

repeated <- function(table, person, a, b, response) {
  means <- aggregate(table[[response]], table[c(b, a, person)], mean)
  idata <- unique(means[c(a, b)])
  wide <- matrix(means$x, ncol = nrow(idata), byrow = TRUE)
  fit <- lm(wide ~ 1)
  frames <- setNames(list(as.formula(paste("~", a)), as.formula(paste("~", b)),
                          as.formula(paste0("~", a, " * ", b))), c(a, b, paste0(a, ":", b)))
  without <- list(~ 1, ~ 1, as.formula(paste("~", a, "+", b)))
  errors <- summary(aov(as.formula(paste0("x ~ ", a, " * ", b, " + Error(", person, " / (", a, " * ", b, "))")),
                        means))
  ss <- lapply(errors, function(stratum) stratum[[1]][["Sum Sq"]])
  with_people <- ss[[1]][length(ss[[1]])] + sum(vapply(ss[-1], function(s) s[2], 0))
  # In anova(), M spans the contrasts and X is projected out.
  effects <- Map(function(M, X, s) {
    test <- anova(fit, M = M, X = X, idata = idata, test = "Spherical")
    epsilon <- stats:::sphericity(SSD(fit), M = M, X = X, idata = idata)$GG.eps
    list(f = test[1, "F"], df1 = test[1, "num Df"], df2 = test[1, "den Df"], p = test[1, "Pr(>F)"],
         epsilon = epsilon, p_gg = test[1, "G-G Pr"], ss = s[1], error_ss = s[2],
         partial_eta2 = s[1] / (s[1] + s[2]), generalized_eta2 = s[1] / (s[1] + with_people))
  }, frames, without, ss[-1])
  effects
}

# --- Type III, MANOVA, counts

type_three <- function(formula, table) {
  fit <- lm(formula, table)
  tests <- drop1(fit, . ~ ., test = "F")
  rows <- rownames(tests)[-1]
  list(error_df = fit$df.residual, mean_square_error = deviance(fit) / fit$df.residual,
       effects = setNames(lapply(rows, function(row) list(df = tests[row, "Df"], ss = tests[row, "Sum of Sq"],
                                                          f = tests[row, "F value"], p = tests[row, "Pr(>F)"])),
                          rows))
}

wilks <- function(table) {
  fit <- manova(cbind(time_s, losses, depth_dm) ~ haptic * rotation * object * block, table)
  tests <- summary(fit, test = "Wilks")$stats
  rows <- setdiff(rownames(tests), "Residuals")
  setNames(lapply(rows, function(row) list(lambda = tests[row, "Wilks"], f = tests[row, "approx F"],
                                           df1 = tests[row, "num Df"], df2 = tests[row, "den Df"],
                                           p = tests[row, "Pr(>F)"])), trimws(rows))
}

counts <- function(formula, table) {
  fit <- glm(formula, poisson, table, control = glm.control(epsilon = 1e-14, maxit = 100))
  s <- summary(fit)$coefficients
  tests <- drop1(fit, test = "LRT")
  last <- nrow(tests)
  list(coefficients = as.list(s[, "Estimate"]), standard_errors = as.list(s[, "Std. Error"]),
       deviance = deviance(fit), df = fit$df.residual,
       pearson_chi2 = sum(residuals(fit, "pearson")^2),
       last_term = rownames(tests)[last], lrt = tests[last, "LRT"], lrt_p = tests[last, "Pr(>Chi)"])
}

# --- Mixed model

mixed <- function(table, response) {
  table$condition <- interaction(table$haptic, table$rotation)
  fit <- lme(as.formula(paste(response, "~ haptic * rotation + object + block")), table,
             random = ~ 1 | person / condition, method = "REML",
             control = lmeControl(tolerance = 1e-10, msTol = 1e-12, maxIter = 500, msMaxIter = 500, opt = "optim"))
  v <- suppressWarnings(as.numeric(VarCorr(fit)[, "Variance"]))
  v <- v[!is.na(v)]
  list(fixed = as.list(fixef(fit)), standard_errors = as.list(sqrt(diag(vcov(fit)))),
       variance_person = v[1], variance_condition = v[2], variance_residual = v[3],
       log_likelihood = as.numeric(logLik(fit)))
}

# --- Pairs: equivalence, effect sizes with intervals, Holm

ends <- function(low, high, f) uniroot(f, c(low, high), tol = 1e-14, maxiter = 10000)$root

pair <- function(table, a, b, margin) {
  means <- aggregate(time_s ~ person + haptic, table, mean)
  d <- means$time_s[means$haptic == a] - means$time_s[means$haptic == b]
  n <- length(d)
  t <- t.test(d)
  both <- t.test(d, conf.level = 0.9)
  statistic <- unname(t$statistic)
  list(first = a, second = b, margin = margin, difference = mean(d), t = statistic, df = unname(t$parameter),
       p = t$p.value, half_width = unname(diff(t$conf.int) / 2),
       p_above = t.test(d, mu = -margin, alternative = "greater")$p.value,
       p_below = t.test(d, mu = margin, alternative = "less")$p.value,
       low_90 = both$conf.int[1], high_90 = both$conf.int[2],
       d_z = mean(d) / sd(d),
       d_z_low = ends(-60, 60, function(ncp) pt(statistic, n - 1, ncp, lower.tail = FALSE) - 0.025) / sqrt(n),
       d_z_high = ends(-60, 60, function(ncp) pt(statistic, n - 1, ncp) - 0.025) / sqrt(n))
}

pairs <- list(pair(balanced, "UaH", "NoH", 2), pair(balanced, "H", "NoH", 2), pair(balanced, "H", "UaH", 2))

# The interval of partial eta squared (Steiger, 2004) from that of the noncentrality of F.
eta2_interval <- function(f, df1, df2, level = 0.9) {
  tail <- (1 - level) / 2
  end <- function(target) {
    g <- function(ncp) pf(f, df1, df2, ncp) - target
    if (g(0) < 0) return(0)
    ends(0, 2000, g)
  }
  low <- end(1 - tail)
  high <- end(tail)
  list(f = f, df1 = df1, df2 = df2, low = low / (low + df1 + df2 + 1), high = high / (high + df1 + df2 + 1))
}

# --- Power

power_of_t <- lapply(list(c(10, 1, 1), c(8, 0.5, 1), c(25, 2, 4.5), c(4, 3, 1.2)), function(x) {
  list(n = x[1], delta = x[2], sd = x[3],
       power = power.t.test(n = x[1], delta = x[2], sd = x[3], type = "paired", strict = TRUE)$power)
})
power_of_f <- lapply(list(c(2, 18, 5), c(1, 9, 10), c(2, 18, 0), c(6, 54, 20), c(3, 648, 1.5), c(1.2, 10.8, 7)),
                     function(x) list(df1 = x[1], df2 = x[2], ncp = x[3],
                                      power = pf(qf(0.95, x[1], x[2]), x[1], x[2], x[3], lower.tail = FALSE)))

shares <- lapply(list(c(0, 30), c(3, 30), c(29, 30), c(30, 30), c(1, 10), c(450, 720)), function(x) {
  suppressWarnings(wilson <- prop.test(x[1], x[2], correct = FALSE)$conf.int)
  exact <- binom.test(x[1], x[2])$conf.int
  list(count = x[1], all = x[2], wilson_low = wilson[1], wilson_high = wilson[2], exact_low = exact[1],
       exact_high = exact[2])
})

balanced_rm <- repeated(balanced, "person", "haptic", "rotation", "time_s")
# A line for each table.
cat(gsub("}, \"", "},\n\"", json(list(
  r = R.version.string, nlme = as.character(packageVersion("nlme")),
  repeated = list(rm_anova2 = repeated(rm2, "Subject", "Time", "Metric", "Performance"),
                  balanced_time = balanced_rm,
                  balanced_depth = repeated(balanced, "person", "haptic", "rotation", "depth_dm")),
  type_three = list(warpbreaks = type_three(breaks ~ wool * tension, warp),
                    unbalanced_time = type_three(time_s ~ haptic * rotation * object * block, unbalanced),
                    unbalanced_depth = type_three(depth_dm ~ haptic * rotation * object * block, unbalanced)),
  wilks = list(balanced = wilks(balanced)),
  counts = list(balanced = counts(losses ~ haptic * rotation + offset(log(time_s)), balanced),
                unbalanced = counts(losses ~ haptic * rotation + offset(log(time_s)), unbalanced),
                unbalanced_with_people = counts(losses ~ person + haptic * rotation + offset(log(time_s)), unbalanced)),
  mixed = list(balanced_time = mixed(balanced, "time_s"), unbalanced_time = mixed(unbalanced, "time_s")),
  pairs = pairs, holm = as.list(p.adjust(vapply(pairs, function(x) x$p, 0), "holm")),
  eta2_intervals = c(unname(lapply(balanced_rm, function(e) eta2_interval(e$f, e$df1, e$df2))),
                     list(eta2_interval(12.141, 2, 648), eta2_interval(0.433, 2, 648), eta2_interval(162.31, 1, 9))),
  power_of_t = power_of_t, power_of_f = power_of_f, shares = shares)), fixed = TRUE), "\n", sep = "")
